#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "process/regular_file.h"

namespace aula {

/// A member of a tar archive.
struct TarMember {
    std::string name;
    std::uint64_t offset = 0;  ///< of its content in the archive
    std::uint64_t size = 0;    ///< bytes
};

/// Bytes of a tar archive (POSIX ustar): the header of a member, or its padding to whole blocks.
/// The owner is 0 and the time is 1970, so that equal members give equal bytes. `name` has at most
/// 100 characters.
std::string tar_header(const std::string& name, std::uint64_t size);
std::string_view tar_padding(std::uint64_t size);

/// The end of an archive.
std::string_view tar_end();

/// Reads archives of these functions.
class TarReader {
 public:
    /// Throws InputError if the file cannot be opened.
    explicit TarReader(const std::filesystem::path& file);

    const std::string& name() const { return name_; }

    /// The next member; empty at the end of the archive. Throws InputError if it is damaged.
    std::optional<TarMember> next();

    /// The content of a member. Throws InputError.
    std::string read(const TarMember& member) const;

 private:
    std::string bytes(std::uint64_t offset, std::uint64_t count) const;

    std::string name_;
    RegularFile file_;
    std::uint64_t next_ = 0;  ///< offset of the next header
};

}  // namespace aula
