#pragma once

#include <filesystem>
#include <string>

namespace aula {

/// A name in the working directory that was free: STEM.EXT, STEM-2.EXT and so on. The file is
/// created empty and exclusively, so that no other program takes the name; the destructor removes
/// it if it is still empty.
class NewFile {
 public:
    /// Throws Error if no file can be created there.
    NewFile(const std::string& stem, const std::string& extension);
    ~NewFile();
    NewFile(const NewFile&) = delete;
    NewFile& operator=(const NewFile&) = delete;

    const std::filesystem::path& path() const { return path_; }

 private:
    std::filesystem::path path_;
};

}  // namespace aula
