#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "process/descriptor.h"

namespace aula {

/// A regular file that is open for reading. Folders, pipes, sockets and devices are refused before
/// they are opened, so that no call blocks and no device is started.
class RegularFile {
 public:
    /// Throws InputError, "FILE: what is wrong; expected EXPECTED".
    RegularFile(std::filesystem::path file, const char* expected);

    const Descriptor& descriptor() const { return descriptor_; }

    /// Bytes of the file when it was opened.
    std::uint64_t size() const { return size_; }

    /// Up to `count` bytes from an offset; fewer at the end of the file. Throws InputError.
    std::string read(std::uint64_t offset, std::uint64_t count) const;

 private:
    Descriptor open() const;
    [[noreturn]] void fail(const std::string& problem) const;

    std::filesystem::path file_;
    const char* expected_;
    Descriptor descriptor_;
    std::uint64_t size_ = 0;
};

/// The bytes of a regular file. Throws InputError as RegularFile, and for more than `max_bytes`.
std::string read_regular_file(const std::filesystem::path& file, std::uint64_t max_bytes,
                              const char* expected);

}  // namespace aula
