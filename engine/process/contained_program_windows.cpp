#include <windows.h>

#include <cstdlib>
#include <new>

#include "process/contained_program.h"

namespace aula {

namespace {

HANDLE output = INVALID_HANDLE_VALUE;

/// Gives the process the lowest integrity, "untrusted" (S-1-16-0), which may open almost no object
/// of the user to write.
void lower_integrity() {
    HANDLE token = nullptr;
    if (OpenProcessToken(GetCurrentProcess(), TOKEN_ADJUST_DEFAULT | TOKEN_QUERY, &token) == 0)
        return;
    SID_IDENTIFIER_AUTHORITY authority = SECURITY_MANDATORY_LABEL_AUTHORITY;
    PSID level = nullptr;
    if (AllocateAndInitializeSid(&authority, 1, SECURITY_MANDATORY_UNTRUSTED_RID, 0, 0, 0, 0, 0, 0,
                                 0, &level) != 0) {
        TOKEN_MANDATORY_LABEL label{};
        label.Label.Sid = level;
        label.Label.Attributes = SE_GROUP_INTEGRITY;
        SetTokenInformation(token, TokenIntegrityLevel, &label,
                            sizeof(label) + GetLengthSid(level));
        FreeSid(level);
    }
    CloseHandle(token);
}

}  // namespace

std::span<const std::byte> map_input() {
    HANDLE const file = GetStdHandle(STD_INPUT_HANDLE);
    LARGE_INTEGER size{};
    if (GetFileSizeEx(file, &size) == 0) std::_Exit(kNotMapped);
    if (size.QuadPart == 0) return {};
    HANDLE const mapping = CreateFileMappingW(file, nullptr, PAGE_READONLY, 0, 0, nullptr);
    if (mapping == nullptr) std::_Exit(kNotMapped);
    const void* const bytes = MapViewOfFile(mapping, FILE_MAP_READ, 0, 0, 0);
    if (bytes == nullptr) std::_Exit(kNotMapped);
    CloseHandle(mapping);
    CloseHandle(file);
    return {static_cast<const std::byte*>(bytes), static_cast<std::size_t>(size.QuadPart)};
}

// The job of ContainedProcess limits memory, processor time and processes.
std::span<const std::byte> contain() {
    // A crash shows no window, and starts no program.
    SetUnhandledExceptionFilter([](EXCEPTION_POINTERS* exception) WINAPI -> LONG {
        TerminateProcess(GetCurrentProcess(), exception->ExceptionRecord->ExceptionCode);
        return EXCEPTION_CONTINUE_SEARCH;
    });
    SetErrorMode(SEM_FAILCRITICALERRORS | SEM_NOGPFAULTERRORBOX | SEM_NOOPENFILEERRORBOX);
    std::set_new_handler([] { std::_Exit(kOutOfMemory); });
    output = GetStdHandle(STD_OUTPUT_HANDLE);
    const std::span<const std::byte> file = map_input();
    lower_integrity();
    return file;
}

bool write_bytes(const void* bytes, std::size_t size) {
    constexpr std::size_t kMost = std::size_t{1} << 20;
    const auto* from = static_cast<const std::byte*>(bytes);
    while (size > 0) {
        DWORD written = 0;
        if (WriteFile(output, from, static_cast<DWORD>(size < kMost ? size : kMost), &written,
                      nullptr) == 0 ||
            written == 0)
            return false;
        from += written;
        size -= written;
    }
    return true;
}

}  // namespace aula
