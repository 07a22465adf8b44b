#pragma once

#include <filesystem>
#include <string>

namespace aula {

/// A new file STEM.EXT, or STEM-2.EXT and so on if that exists. The constructor creates it empty,
/// exclusively and locked, which reserves the name against other programs. An empty file without a
/// lock is taken: an ended program has left it. The destructor removes the file if it is still
/// empty.
class NewFile {
 public:
    /// Throws InputError if the file cannot be created.
    NewFile(const std::string& stem, const std::string& extension);
    ~NewFile();
    NewFile(const NewFile&) = delete;
    NewFile& operator=(const NewFile&) = delete;

    const std::filesystem::path& path() const { return path_; }

 private:
    std::filesystem::path path_;
    int descriptor_ = -1;  ///< of the empty file, for its lock
};

}  // namespace aula
