#pragma once

#include <string>

namespace aula::test {

/// A shared library as a host loads it. It stays loaded.
class SharedLibrary {
 public:
    /// Throws std::runtime_error if it cannot be loaded.
    explicit SharedLibrary(const std::string& file);

    /// A function or an object that the library exports; null if it does not.
    template <typename Pointer>
    Pointer find(const char* name) const {
        return reinterpret_cast<Pointer>(address(name));
    }

    /// The system's handle.
    void* handle() const { return handle_; }

 private:
    void* address(const char* name) const;

    void* handle_;
};

}  // namespace aula::test
