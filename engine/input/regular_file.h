#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace aula {

/// The bytes of a regular file. Pipes, devices and sockets are refused, so that it never waits.
/// Throws Error whose message is the bare reason: the file cannot be opened or read, is of another
/// kind, or holds more than `most_bytes`.
std::string read_regular_file(const std::filesystem::path& file, std::uint64_t most_bytes);

}  // namespace aula
