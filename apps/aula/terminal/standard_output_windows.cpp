#include <cstdio>

#include "apps/aula/terminal/standard_output.h"

namespace aula {

// Windows does not tell whether the reader of a pipe has ended.
void flush_standard_output() {
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
        throw Failure("standard output: cannot write");
}

}  // namespace aula
