#include <windows.h>

#include <psapi.h>
#include <tlhelp32.h>

#include "tests/plugin/editor/clap_editor_host.h"
#include "tests/plugin/editor/editor_system.h"
#include "tests/plugin/editor/vst3_editor_host.h"

namespace aula::test {

bool has_display() { return true; }

std::vector<std::string> editor_formats() { return {"CLAP", "VST3"}; }

std::unique_ptr<EditorFormat> editor_host(const std::string& format) {
    if (format == "CLAP") return std::make_unique<ClapEditorHost>();
    return std::make_unique<Vst3EditorHost>();
}

void set_home(const std::string& folder) { _putenv_s("USERPROFILE", folder.c_str()); }

HeldResources held_resources() {
    HeldResources held;
    PROCESS_MEMORY_COUNTERS memory{};
    GetProcessMemoryInfo(GetCurrentProcess(), &memory, sizeof(memory));
    held.memory_mb = static_cast<double>(memory.WorkingSetSize) * 1e-6;
    DWORD handles = 0;
    GetProcessHandleCount(GetCurrentProcess(), &handles);
    held.files = handles;
    HANDLE all = CreateToolhelp32Snapshot(TH32CS_SNAPTHREAD, 0);
    THREADENTRY32 thread{};
    thread.dwSize = sizeof(thread);
    for (BOOL more = Thread32First(all, &thread); more != 0; more = Thread32Next(all, &thread)) {
        if (thread.th32OwnerProcessID == GetCurrentProcessId()) ++held.threads;
    }
    CloseHandle(all);
    return held;
}

}  // namespace aula::test
