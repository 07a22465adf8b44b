// A program for a ContainedProcess on any system, that does what its input names: "answer" and a
// text answers with it, twice.

#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "process/contained_program.h"

int main() {
    const std::span<const std::byte> input = aula::contain();
    const std::string_view what(reinterpret_cast<const char*>(input.data()), input.size());
    if (what.starts_with("answer ")) {
        const std::string_view text = what.substr(7);
        if (!aula::write_bytes(text.data(), text.size())) return 1;
        aula::write_bytes(text.data(), text.size());
    }
    if (what == "abort") std::abort();
    volatile unsigned long long steps = 0;
    while (what == "compute") steps = steps + 1;
    if (what == "crash") *static_cast<volatile int*>(nullptr) = 0;
    if (what == "memory") {
        std::vector<char*> blocks;
        while (true) std::memset(blocks.emplace_back(new char[std::size_t{1} << 24]), 1, 1 << 24);
    }
    std::_Exit(0);
}
