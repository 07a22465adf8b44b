#pragma once

#include <filesystem>

namespace aula {

/// The file that a name stands for, which need not exist: links are followed to the last one.
/// Throws std::system_error if a name is too long, or links form a loop.
std::filesystem::path file_behind_links(const std::filesystem::path& name);

/// A file that is written under a random name in the target's folder and renamed by commit().
/// Without commit() it is removed. It is created exclusively, is locked, and never follows a link.
class PartFile {
 public:
    /// An existing file is replaced and its permissions are kept; of a symbolic link the file that
    /// it points to, which need not exist. Removes what a killed process has left of the same
    /// target. Throws InputError if the existing file is write-protected, std::system_error if the
    /// folder is not writable, the name is too long, or links form a loop.
    explicit PartFile(const std::filesystem::path& file);
    ~PartFile();
    PartFile(const PartFile&) = delete;
    PartFile& operator=(const PartFile&) = delete;

    int descriptor() const { return descriptor_; }

    /// Flushes the file to the disk, renames it, and flushes its name. Throws std::system_error,
    /// for instance if the disk is full. Nothing may be written afterwards.
    void commit();

    /// Removes the unfinished files of all threads before the program exits immediately, and
    /// renames those that commit() is flushing. Afterwards constructor, destructor and commit()
    /// block.
    static void abandon_all();

 private:
    std::filesystem::path target_;
    std::filesystem::path temporary_;  ///< in the target's folder and thus file system
    int descriptor_;
    bool complete_ = false;     ///< commit() was called
    PartFile* next_ = nullptr;  ///< in the list of all PartFiles
};

}  // namespace aula
