#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

namespace aula {

/// Owns an open file descriptor.
class Descriptor {
 public:
    /// Takes ownership. Moves the descriptor above the standard descriptors, which a child process
    /// replaces.
    explicit Descriptor(int number);
    ~Descriptor() { reset(); }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;

    void reset();
    int number() const { return number_; }

 private:
    int number_;
};

/// A child process that reads an untrusted file by a library whose parser may loop, crash or
/// allocate without limit. Its program is embedded in the host's, is executed from memory, and
/// limits its own resources (limit_resources()). It reads the file from standard input and answers
/// on standard output. The destructor kills it and waits for it, by its process id only.
class ContainedProcess {
 public:
    /// Starts the program. Throws InputError, with what was expected, unless `file` is a regular
    /// file that may be read; Failure if the process cannot be started.
    ContainedProcess(std::span<const std::byte> program, const std::filesystem::path& file,
                     const char* expected);
    ~ContainedProcess();
    ContainedProcess(const ContainedProcess&) = delete;
    ContainedProcess& operator=(const ContainedProcess&) = delete;

    /// Reads a value or all elements of a vector from the answer. Returns false if the answer ends
    /// before or does not arrive in time.
    template <typename T>
    bool read(T& value) {
        return read_bytes(&value, sizeof(value));
    }
    template <typename T>
    bool read(std::vector<T>& values) {
        return read_bytes(values.data(), values.size() * sizeof(T));
    }

 private:
    using Clock = std::chrono::steady_clock;

    bool read_bytes(void* bytes, std::size_t size);

    Clock::time_point deadline_;
    std::optional<Descriptor> output_;
    int id_ = -1;
};

}  // namespace aula
