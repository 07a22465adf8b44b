#pragma once

#include <utility>

namespace aula {

/// Owns an open file descriptor.
class Descriptor {
 public:
    /// Takes ownership. Moves the descriptor above the standard descriptors, which a child process
    /// replaces.
    explicit Descriptor(int number);
    Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
    Descriptor& operator=(Descriptor&&) = delete;
    ~Descriptor() { reset(); }

    void reset();
    int number() const { return number_; }
    int release() { return std::exchange(number_, -1); }

 private:
    int number_;
};

}  // namespace aula
