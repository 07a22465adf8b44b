#include <fcntl.h>
#include <io.h>
#include <sys/stat.h>
#include <unistd.h>
#include <windows.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include "aula/exception.h"
#include "process/files.h"

namespace aula {

namespace {

constexpr DWORD kShareAll = FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE;

[[noreturn]] void fail(int error) { throw std::system_error(error, std::generic_category()); }

/// The error of the last call of Windows, whose own words may be of another language.
[[noreturn]] void fail() {
    const std::error_code error(static_cast<int>(GetLastError()), std::system_category());
    const std::error_condition condition = error.default_error_condition();
    if (condition.category() != std::generic_category()) throw std::system_error(error);
    fail(condition.value());
}

HANDLE handle(int descriptor) { return reinterpret_cast<HANDLE>(_get_osfhandle(descriptor)); }

/// Opens a file, which other programs may open, rename and remove meanwhile, as on other systems.
/// Returns -1 with the last error.
int open_shared(const std::filesystem::path& file, DWORD access, DWORD creation, DWORD flags = 0) {
    HANDLE const opened = CreateFileW(file.c_str(), access, kShareAll, nullptr, creation,
                                      FILE_ATTRIBUTE_NORMAL | flags, nullptr);
    if (opened == INVALID_HANDLE_VALUE) return -1;
    return _open_osfhandle(reinterpret_cast<intptr_t>(opened),
                           _O_BINARY | _O_NOINHERIT | (access == GENERIC_READ ? _O_RDONLY : 0));
}

int checked(int descriptor) {
    if (descriptor < 0) fail();
    return descriptor;
}

/// Whether an open file still has the name.
bool has_name(int descriptor, const std::filesystem::path& name) {
    HANDLE const named = CreateFileW(name.c_str(), 0, kShareAll, nullptr, OPEN_EXISTING,
                                     FILE_FLAG_BACKUP_SEMANTICS, nullptr);
    if (named == INVALID_HANDLE_VALUE) return false;
    BY_HANDLE_FILE_INFORMATION one{};
    BY_HANDLE_FILE_INFORMATION other{};
    const bool known = GetFileInformationByHandle(handle(descriptor), &one) != 0 &&
                       GetFileInformationByHandle(named, &other) != 0;
    CloseHandle(named);
    return known && one.dwVolumeSerialNumber == other.dwVolumeSerialNumber &&
           one.nFileIndexHigh == other.nFileIndexHigh && one.nFileIndexLow == other.nFileIndexLow;
}

}  // namespace

Descriptor::Descriptor(int number) : number_(number) {}

void Descriptor::reset() {
    if (number_ >= 0) close(std::exchange(number_, -1));
}

std::filesystem::path program_file(std::error_code& error) {
    error.clear();
    std::wstring name(MAX_PATH, L'\0');
    while (GetModuleFileNameW(nullptr, name.data(), static_cast<DWORD>(name.size())) == name.size())
        name.resize(2 * name.size());
    return name.c_str();
}

// Of the C library: 512 streams.
std::size_t most_open_files() { return 512; }

std::error_code folder_refusal(const std::filesystem::path&) { return {}; }

int open_to_read(const std::filesystem::path& file) {
    return checked(open_shared(file, GENERIC_READ, OPEN_EXISTING));
}

int open_device(const std::filesystem::path& file) {
    return checked(open_shared(file, GENERIC_WRITE, OPEN_EXISTING));
}

std::optional<int> create_file(const std::filesystem::path& file, bool) {
    // DELETE: the file is renamed while it is open.
    const int descriptor = open_shared(file, GENERIC_READ | GENERIC_WRITE | DELETE, CREATE_NEW);
    if (descriptor < 0 &&
        (GetLastError() == ERROR_FILE_EXISTS || GetLastError() == ERROR_ALREADY_EXISTS))
        return std::nullopt;
    return checked(descriptor);
}

Descriptor anonymous_file(std::string_view bytes) {
    wchar_t folder[MAX_PATH + 1]{};
    wchar_t name[MAX_PATH + 1]{};
    if (GetTempPathW(MAX_PATH, folder) == 0 || GetTempFileNameW(folder, L"aul", 0, name) == 0)
        fail();
    Descriptor file(checked(open_shared(name, GENERIC_READ | GENERIC_WRITE | DELETE, OPEN_EXISTING,
                                        FILE_ATTRIBUTE_TEMPORARY | FILE_FLAG_DELETE_ON_CLOSE)));
    write_all(file.number(), bytes);
    return file;
}

std::optional<std::uint64_t> regular_size(int descriptor) {
    LARGE_INTEGER size{};
    if (GetFileType(handle(descriptor)) != FILE_TYPE_DISK) return std::nullopt;
    if (GetFileSizeEx(handle(descriptor), &size) == 0) fail();
    return static_cast<std::uint64_t>(size.QuadPart);
}

std::size_t read_at(int descriptor, void* bytes, std::size_t size, std::uint64_t offset) {
    OVERLAPPED at{};
    at.Offset = static_cast<DWORD>(offset);
    at.OffsetHigh = static_cast<DWORD>(offset >> 32);
    constexpr std::size_t kMost = std::size_t{1} << 30;
    DWORD got = 0;
    if (ReadFile(handle(descriptor), bytes, static_cast<DWORD>(std::min(size, kMost)), &got, &at) ==
            0 &&
        GetLastError() != ERROR_HANDLE_EOF)
        fail();
    return got;
}

void write_all(int descriptor, std::string_view bytes) {
    constexpr std::size_t kMost = std::size_t{1} << 30;
    while (!bytes.empty()) {
        const auto size = static_cast<unsigned>(std::min(bytes.size(), kMost));
        const int written = ::write(descriptor, bytes.data(), size);
        if (written < 0) fail(errno);
        bytes.remove_prefix(static_cast<std::size_t>(written));
    }
}

void close_file(int descriptor) {
    if (close(descriptor) != 0) fail(errno);
}

void flush_file(int descriptor) {
    if (FlushFileBuffers(handle(descriptor)) == 0) fail();
}

void flush_files(const std::filesystem::path& folder) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
        if (!entry.is_regular_file()) continue;
        const Descriptor file(
            checked(open_shared(entry.path(), GENERIC_READ | GENERIC_WRITE, OPEN_EXISTING)));
        flush_file(file.number());
    }
}

// NTFS keeps a journal of names, which no program flushes.
void flush_names(const std::filesystem::path&) {}

void copy_permissions(int, const std::filesystem::path&) {}

void copy_folder_permissions(const std::filesystem::path&, const std::filesystem::path&, bool) {}

void check_replaceable(const std::filesystem::path& target) {
    const DWORD attributes = GetFileAttributesW(target.c_str());
    // Of a folder the attribute protects nothing.
    if (attributes == INVALID_FILE_ATTRIBUTES || (attributes & FILE_ATTRIBUTE_READONLY) == 0 ||
        (attributes & FILE_ATTRIBUTE_DIRECTORY) != 0)
        return;
    throw InputError(target.string(), "",
                     "is read-only and would be replaced; expected a file without this attribute");
}

void rename_flushed(const std::filesystem::path& from, const std::filesystem::path& to) {
    if (MoveFileExW(from.c_str(), to.c_str(), MOVEFILE_REPLACE_EXISTING) == 0) fail();
}

bool rename_to_free_name(const std::filesystem::path& from, const std::filesystem::path& to) {
    if (MoveFileExW(from.c_str(), to.c_str(), 0) != 0) return true;
    if (GetLastError() != ERROR_ALREADY_EXISTS && GetLastError() != ERROR_FILE_EXISTS) fail();
    return false;
}

bool exchange_names(const std::filesystem::path&, const std::filesystem::path&) noexcept {
    return false;
}

NameLock lock_name(int descriptor, const std::filesystem::path& name) {
    // Of a byte far behind the end: a locked one can be read and written by nobody else.
    OVERLAPPED at{};
    at.OffsetHigh = 0x40000000;
    const bool locked =
        LockFileEx(handle(descriptor), LOCKFILE_EXCLUSIVE_LOCK | LOCKFILE_FAIL_IMMEDIATELY, 0, 1, 0,
                   &at) != 0;
    const DWORD error = GetLastError();
    if (!locked && (error == ERROR_LOCK_VIOLATION || error == ERROR_IO_PENDING))
        return NameLock::busy;
    if (!has_name(descriptor, name)) return NameLock::busy;
    return locked ? NameLock::locked : NameLock::unsupported;
}

int open_locked(const std::filesystem::path& file) {
    const int descriptor = open_shared(file, GENERIC_READ | GENERIC_WRITE, OPEN_EXISTING,
                                       FILE_FLAG_OPEN_REPARSE_POINT);
    if (descriptor < 0 || lock_name(descriptor, file) == NameLock::locked) return descriptor;
    close(descriptor);
    return -1;
}

std::optional<int> lock_folder(const std::filesystem::path& folder) {
    // Folders have no locks, but nobody else can open it with the same access.
    HANDLE const opened = CreateFileW(folder.c_str(), FILE_ADD_FILE | SYNCHRONIZE,
                                      FILE_SHARE_READ | FILE_SHARE_DELETE, nullptr, OPEN_EXISTING,
                                      FILE_FLAG_BACKUP_SEMANTICS, nullptr);
    if (opened == INVALID_HANDLE_VALUE && GetLastError() == ERROR_SHARING_VIOLATION)
        return std::nullopt;
    if (opened == INVALID_HANDLE_VALUE) fail();
    return _open_osfhandle(reinterpret_cast<intptr_t>(opened), _O_BINARY | _O_NOINHERIT);
}

}  // namespace aula
