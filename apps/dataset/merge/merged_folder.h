#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "apps/output/output_folder.h"

namespace aula {

/// An output folder that lists the SHA-256 of its files in SHA256SUMS. It replaces a folder that
/// contains listed files only, which its owner may write to.
class MergedFolder {
 public:
    /// Throws InputError if it cannot be created or would replace other files, or if another
    /// process writes it.
    explicit MergedFolder(std::filesystem::path folder);

    /// The path of a file to write now.
    std::filesystem::path path(const std::string& name) const { return out_.path(name); }

    /// Its path after commit(), for messages.
    std::filesystem::path named(const std::string& name) const { return folder_ / name; }

    /// Writes a file; the name may have a folder. Throws Failure.
    void write(const std::string& name, std::string_view content);

    /// Appends a file that has been written at path() to SHA256SUMS. Throws Failure.
    void list(const std::string& name);

    /// Writes SHA256SUMS and commits the folder. Throws Failure, or InputError if files have been
    /// added to the folder that it replaces.
    void commit();

 private:
    std::filesystem::path folder_;
    OutputFolder out_;
    std::string sums_;
};

}  // namespace aula
