#include "apps/aula/terminal/standard_output.h"

#include <poll.h>
#include <unistd.h>

#include <cstdio>

namespace aula {

void flush_standard_output() {
    if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return;
    // errno may be that of a later call than the one which failed.
    pollfd output{.fd = STDOUT_FILENO, .events = 0, .revents = 0};
    if (poll(&output, 1, 0) == 1 && (output.revents & (POLLERR | POLLHUP)) != 0)
        throw ReaderEnded();
    throw Failure("standard output: cannot write");
}

}  // namespace aula
