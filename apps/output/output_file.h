#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "audio/file/part_file.h"

namespace aula {

/// A text file that appears under its name at commit(); without commit() nothing remains
/// (PartFile). A device or a pipe is written directly.
class OutputFile {
 public:
    /// Throws InputError if the file cannot be written or is write-protected.
    explicit OutputFile(const std::filesystem::path& file) : OutputFile(file, file) {}

    /// `named`: the file in messages, which later has this name (OutputFolder).
    OutputFile(const std::filesystem::path& file, std::filesystem::path named);
    ~OutputFile();
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;

    /// Throws Failure if writing fails (disk full).
    void write(std::string_view text);
    void commit();

 private:
    std::filesystem::path file_;    ///< in messages
    std::optional<PartFile> part_;  ///< empty for a device or a pipe
    int descriptor_ = -1;
};

}  // namespace aula
