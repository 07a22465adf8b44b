#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace aula {

// For the programs that a ContainedProcess runs.

/// Memory of such a program beyond the mapped file: several times that of the largest valid file.
inline constexpr std::size_t kContainedMemory_bytes = std::size_t{1} << 30;

/// Processor time of such a program. A sound of 64 channels of Opus of the longest duration takes
/// half of it. ContainedProcess limits the time between two parts of the answer.
inline constexpr unsigned kContainedTime_s = 3600;

/// Exit statuses of a program that has no memory left or cannot map the file.
inline constexpr int kOutOfMemory = 5;  // not 3, with which abort() ends on Windows
inline constexpr int kNotMapped = 4;

// contain() does all of the following on Linux. On macOS there is no filter of calls; instead of
// Landlock the sandbox of the system allows computation only, unless the host is in one. On
// Windows, where the job of the ChildProcess limits memory, processor time and processes, it maps
// the file and gives the process the lowest integrity: it may write to no file.

/// The file on standard input, mapped. If it cannot be mapped the program ends with the status
/// kNotMapped.
std::span<const std::byte> map_input();

/// Closes all descriptors but standard output and error: a host may let its child processes inherit
/// others. A kernel before Linux 5.9 closes standard input alone.
void close_descriptors();

/// Limits memory, processor time and sizes of files, and allows no new descriptor. Without memory
/// the program ends with the status kOutOfMemory.
void limit_resources(std::size_t mapped_bytes, unsigned time_s = kContainedTime_s);

/// Forbids access to all files that are not open, and to networks, by Landlock. A kernel without
/// Landlock changes nothing.
void forbid_files();

/// Restricts system calls by seccomp to those that use memory, write to standard output or error,
/// tell the time and end the process. Opening a file fails with EACCES; any other call ends the
/// process with SIGSYS. A kernel without seccomp, or another processor than x86-64, AArch64 and
/// 64-bit RISC-V, changes nothing.
void filter_calls();

/// Returns the file on standard input, mapped, after all of the above.
std::span<const std::byte> contain();

/// Writes bytes, a value or all elements of a vector to the answer.
bool write_bytes(const void* bytes, std::size_t size);
template <typename T>
bool write(const T& value) {
    return write_bytes(&value, sizeof(value));
}
template <typename T>
bool write(const std::vector<T>& values) {
    return write_bytes(values.data(), values.size() * sizeof(T));
}

}  // namespace aula
