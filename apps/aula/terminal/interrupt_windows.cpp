#include <fcntl.h>
#include <io.h>
#include <windows.h>

// After windows.h.
#include <shellapi.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "apps/aula/terminal/interrupt.h"
#include "audio/file/part_file.h"

namespace aula {

namespace {

/// Time for an orderly end, as on other systems.
constexpr DWORD kOrderlyEnd_ms = 800;

std::atomic<int> first_signal = 0;

/// Records the first interrupt. Ends the process after kOrderlyEnd_ms or at a second interrupt.
BOOL WINAPI handle_interrupt(DWORD event) {
    const int signal = event == CTRL_C_EVENT || event == CTRL_BREAK_EVENT ? SIGINT : SIGTERM;
    int none = 0;
    if (first_signal.compare_exchange_strong(none, signal)) Sleep(kOrderlyEnd_ms);
    PartFile::abandon_all();
    std::_Exit(128 + signal);
}

}  // namespace

void set_up_process() {
    SetConsoleCtrlHandler(handle_interrupt, TRUE);
    SetConsoleOutputCP(CP_UTF8);
    // Lines end as on other systems.
    for (FILE* const file : {stdout, stderr}) _setmode(_fileno(file), _O_BINARY);
}

int interrupt_signal() { return first_signal; }

std::vector<std::string> command_line(int, char**) {
    int count = 0;
    wchar_t** const words = CommandLineToArgvW(GetCommandLineW(), &count);
    std::vector<std::string> line;
    for (int i = 0; i < count; ++i) line.push_back(std::filesystem::path(words[i]).string());
    LocalFree(words);
    return line;
}

}  // namespace aula
