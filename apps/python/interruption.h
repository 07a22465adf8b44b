#pragma once

#include <pybind11/pybind11.h>

#include <chrono>

namespace aula {

namespace py = pybind11;

/// Asks the interpreter ten times a second whether a signal, such as Ctrl-C, has raised an
/// exception. Called without the interpreter's lock.
class Interruption {
 public:
    /// True until there is an exception.
    bool continues() {
        const auto now = std::chrono::steady_clock::now();
        if (now < next_) return true;
        next_ = now + std::chrono::milliseconds(100);
        const py::gil_scoped_acquire acquired;
        raised_ = PyErr_CheckSignals() != 0;
        return !raised_;
    }

    /// Throws the exception, if there is one. Called with the interpreter's lock.
    void rethrow() const {
        if (raised_) throw py::error_already_set();
    }

 private:
    std::chrono::steady_clock::time_point next_;
    bool raised_ = false;
};

}  // namespace aula
