#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <variant>

#include "process/descriptor.h"

namespace aula {

/// The program of a contained process: the bytes of an executable file, or its path. Windows runs
/// files only.
using ContainedProgram = std::variant<std::span<const std::byte>, std::filesystem::path>;

#if defined(_WIN32)
/// A file in the folder of the program or the library that contains this code.
std::filesystem::path beside_binary(const std::filesystem::path& file);
#endif

/// A child process that reads a file from standard input and answers on standard output, for
/// ContainedProcess. Its standard error is discarded; it has no other file of the host.
class ChildProcess {
 public:
    /// How a process ended by itself.
    enum class End { early, out_of_memory, not_mapped, forbidden_call, out_of_time, crashed };

    /// What the system must have, for the message of an error.
    static const char* const kNeeds;

    /// Starts the program. Throws std::system_error.
    ChildProcess(const ContainedProgram& program, const Descriptor& input);
    /// Ends the process, by its process id only, and waits for it.
    ~ChildProcess();
    ChildProcess(const ChildProcess&) = delete;
    ChildProcess& operator=(const ChildProcess&) = delete;

    /// Waits for bytes of the answer, or its end. Returns false after the timeout.
    bool wait(std::chrono::nanoseconds timeout);

    /// Reads what has arrived after wait(), up to `size` bytes. Returns 0 at the end of the answer.
    std::size_t read(void* bytes, std::size_t size);

    /// Processor time of the process; 0 if it is not known any more.
    std::chrono::nanoseconds processor_time() const;

    /// After the end of the answer: ends the process, and says how it has ended before.
    End end();

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
