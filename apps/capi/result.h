#pragma once

#include <exception>
#include <new>
#include <string>
#include <utility>

#include "aula.h"
#include "aula/exception.h"

namespace aula {

/// Stores a copy of a message, as one line without control characters, for aula_message() on the
/// calling thread. Returns `result`.
int fail(int result, const char* message) noexcept;

/// The same without allocating or locking: `literal` must remain valid.
int fail_wait_free(int result, const char* literal) noexcept;

/// The result of a function that may throw; stores the message of its exception.
template <typename Function>
int result_of(Function&& function) noexcept {
    try {
        std::forward<Function>(function)();
        return AULA_OK;
    } catch (const InputError& error) {
        return fail(AULA_INPUT_ERROR, error.what());
    } catch (const std::bad_alloc&) {
        return fail_wait_free(AULA_FAILURE, "out of memory");
    } catch (const std::exception& error) {
        return fail(AULA_FAILURE, error.what());
    } catch (...) {
        return fail_wait_free(AULA_FAILURE, "unknown failure");
    }
}

/// Throws InputError if an argument is null.
template <typename T>
T& not_null(T* argument, const char* name) {
    if (argument == nullptr) throw InputError(std::string(name) + " is null");
    return *argument;
}

}  // namespace aula
