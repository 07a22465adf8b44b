#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace aula {

/// The bytes of a regular file. Pipes, devices and sockets are refused, so that the call never
/// blocks. Throws InputError with the reason only: the file cannot be opened or read, is not
/// regular, or is larger than `max_bytes`.
std::string read_regular_file(const std::filesystem::path& file, std::uint64_t max_bytes);

}  // namespace aula
