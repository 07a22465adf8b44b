#pragma once

#include <filesystem>

namespace aula {

/// A file that is written under a random name beside its own, which it gets in commit(); without
/// commit() nothing is left behind. It is created exclusively, never through a link.
class PartFile {
 public:
    /// Replaces what is there, of a symbolic link what it points to, and keeps its permissions.
    /// Throws std::system_error if the place cannot be written to.
    explicit PartFile(const std::filesystem::path& file);
    ~PartFile();
    PartFile(const PartFile&) = delete;
    PartFile& operator=(const PartFile&) = delete;

    int descriptor() const { return descriptor_; }

    /// Has the file written to the disk, which may only now turn out to be full, and names it.
    /// Throws std::system_error.
    void commit();

    /// Removes all that is being written, of any thread, for a program that ends at once; from then
    /// on a PartFile that is made, committed or destroyed waits for ever.
    static void abandon_all();

 private:
    std::filesystem::path target_;
    std::filesystem::path temporary_;  ///< in the target's folder: renaming stays in a file system
    int descriptor_;
    PartFile* next_ = nullptr;  ///< of all that are being written
};

}  // namespace aula
