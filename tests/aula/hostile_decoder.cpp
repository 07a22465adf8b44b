// A library to be loaded before libsndfile: its decoder is one that a malformed file has taken over
// and that does what the environment variable AULA_HOSTILE_DECODER names.

#include <sys/socket.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <vector>

extern "C" void* sf_open_virtual(void*, int, void*, void*) {
    // 0, in a way that the compiler cannot follow.
    static volatile std::uintptr_t zero = 0;
    const char* const named = std::getenv("AULA_HOSTILE_DECODER");
    const std::string_view what = named == nullptr ? "" : named;
    if (what == "crash") *reinterpret_cast<volatile char*>(zero) = 1;
    if (what == "memory")
        zero = static_cast<std::uintptr_t>(std::vector<char>(std::size_t{1} << 31)[zero]);
    if (what == "socket") socket(AF_INET, SOCK_STREAM, 0);
    if (what == "loop") {
        while (zero == 0) continue;
    }
    return nullptr;
}
