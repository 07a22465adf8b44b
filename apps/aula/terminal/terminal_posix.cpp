#include <sys/ioctl.h>
#include <unistd.h>

#include "apps/aula/terminal/terminal.h"

namespace aula {

std::optional<std::size_t> terminal_columns() {
    winsize size{};
    if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col <= 1) return std::nullopt;
    return size.ws_col;
}

}  // namespace aula
