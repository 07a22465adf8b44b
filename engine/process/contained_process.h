#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "process/child_process.h"

namespace aula {

/// A child process that reads an untrusted file by a library whose parser may loop, crash or
/// allocate without limit. Its program is embedded in the host's and executed from memory, on
/// macOS from a temporary file, or is a file, and confines itself (contain()). It reads the file
/// from standard input and answers on standard output; on Linux its environment holds
/// LD_LIBRARY_PATH only, with the folders in which the host's binary finds its libraries. On
/// Windows a job limits its memory and processor time, and forbids it further processes. The
/// destructor ends it.
class ContainedProcess {
 public:
    /// Starts the program. Throws InputError, with what was expected, unless `file` is a regular
    /// file that may be read; Failure if the process cannot be started.
    ContainedProcess(const ContainedProgram& program, std::filesystem::path file,
                     std::string expected);
    /// The same for a file in memory; `name` is that in messages.
    ContainedProcess(const ContainedProgram& program, std::string_view bytes,
                     std::filesystem::path name, std::string expected);
    /// Reads a value, all elements of a vector, or bytes from the answer. Throws InputError, with
    /// the reason, if the answer ends before or does not arrive in time.
    template <typename T>
    void read(T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        read_bytes(&value, sizeof(value));
    }
    template <typename T>
    void read(std::vector<T>& values) {
        read_bytes(values.data(), values.size() * sizeof(T));
    }
    void read_bytes(void* bytes, std::size_t size);

    /// Throws the InputError that says what is wrong with the file, and what was expected.
    [[noreturn]] void refuse(const std::string& problem) const;

 private:
    using Clock = std::chrono::steady_clock;

    void begin(const ContainedProgram& program, const Descriptor& input);
    /// Waits for the next part of the answer.
    void wait_for_answer();
    [[noreturn]] void refuse_as_ended();
    [[noreturn]] void refuse_as_damaged(const std::string& how) const;

    std::filesystem::path file_;
    std::string expected_;
    std::optional<ChildProcess> process_;
    // When the last part of the answer arrived, and the processor time until then.
    Clock::time_point answered_;
    std::chrono::nanoseconds computed_{0};
};

}  // namespace aula
