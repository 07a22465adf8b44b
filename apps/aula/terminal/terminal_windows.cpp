#include <windows.h>

#include "apps/aula/terminal/terminal.h"

namespace aula {

std::optional<std::size_t> terminal_columns() {
    CONSOLE_SCREEN_BUFFER_INFO buffer{};
    if (GetConsoleScreenBufferInfo(GetStdHandle(STD_ERROR_HANDLE), &buffer) == 0)
        return std::nullopt;
    const int columns = buffer.srWindow.Right - buffer.srWindow.Left + 1;
    if (columns <= 1) return std::nullopt;
    return static_cast<std::size_t>(columns);
}

}  // namespace aula
