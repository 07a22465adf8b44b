// A library in place of libsndfile. Its decoder is one that a malformed file has taken over: it
// does what the first bytes of the file name. All functions that aula and its readers link are
// here.

#include <sys/socket.h>

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace {

using Offset = std::int64_t;

/// SF_VIRTUAL_IO of libsndfile.
struct Input {
    Offset (*length)(void*);
    Offset (*seek)(Offset, int, void*);
    Offset (*read)(void*, Offset, void*);
};

}  // namespace

extern "C" {

void* sf_open_virtual(Input* input, int, void*, void* user) {
    // 0, in a way that the compiler cannot follow.
    static volatile std::uintptr_t zero = 0;
    char head[8]{};
    input->read(head, sizeof(head), user);
    const std::string_view what(head + 4, 4);  // after the bytes that tell the format
    if (what == "fail") *reinterpret_cast<volatile char*>(zero) = 1;
    if (what == "grow")
        zero = static_cast<unsigned char>(std::vector<char>(std::size_t{1} << 31)[zero]);
    if (what == "call") socket(AF_INET, SOCK_STREAM, 0);
    if (what == "loop") {
        while (zero == 0) continue;
    }
    return nullptr;
}
void* sf_open_fd(int, int, void*, int) { return nullptr; }
int sf_close(void*) { return 0; }
int sf_error(void*) { return 0; }
int sf_command(void*, int, void*, int) { return 0; }
Offset sf_readf_float(void*, float*, Offset) { return 0; }
Offset sf_writef_float(void*, const float*, Offset) { return 0; }
Offset sf_writef_int(void*, const int*, Offset) { return 0; }
}
