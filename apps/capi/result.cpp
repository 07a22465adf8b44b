#include "apps/capi/result.h"

#include <string>

#include "apps/output/printable.h"

namespace aula {

namespace {

// Static storage of the thread: access never allocates, also in a library that was loaded at run
// time.
[[gnu::tls_model("initial-exec")]] thread_local const char* newest_message = "";

thread_local std::string copied_message;

}  // namespace

int fail(int result, const char* message) noexcept {
    try {
        copied_message = printable_line(message);
    } catch (const std::bad_alloc&) {
        return fail_wait_free(result, "out of memory");
    }
    return fail_wait_free(result, copied_message.c_str());
}

int fail_wait_free(int result, const char* literal) noexcept {
    newest_message = literal;
    return result;
}

}  // namespace aula

extern "C" const char* aula_version() { return AULA_VERSION; }

extern "C" const char* aula_message() { return aula::newest_message; }
