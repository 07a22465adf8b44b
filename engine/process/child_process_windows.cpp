#include <windows.h>

#include <array>
#include <atomic>
#include <cstring>
#include <random>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <io.h>

#include "process/child_process.h"
#include "process/contained_program.h"

namespace aula {

namespace {

[[noreturn]] void fail_start() {
    const std::error_code error(static_cast<int>(GetLastError()), std::system_category());
    throw std::system_error(error.default_error_condition().value(), std::generic_category());
}

/// Owns a handle of Windows.
class Handle {
 public:
    explicit Handle(HANDLE handle = nullptr) : handle_(handle) {}
    Handle(Handle&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
    Handle& operator=(Handle&& other) noexcept {
        std::swap(handle_, other.handle_);
        return *this;
    }
    ~Handle() {
        if (handle_ != nullptr) CloseHandle(handle_);
    }

    HANDLE get() const { return handle_; }

 private:
    HANDLE handle_;
};

Handle checked(HANDLE handle) {
    if (handle == nullptr || handle == INVALID_HANDLE_VALUE) fail_start();
    return Handle(handle);
}

/// What the process inherits.
SECURITY_ATTRIBUTES inherited{sizeof(SECURITY_ATTRIBUTES), nullptr, TRUE};

/// The two ends of a pipe: reading does not wait, and the process inherits the other one. Pipes
/// without a name are always waited for.
std::pair<Handle, Handle> make_pipe() {
    static std::atomic<unsigned> number{0};
    const std::wstring name = L"\\\\.\\pipe\\aula-" + std::to_wstring(GetCurrentProcessId()) +
                              L"-" + std::to_wstring(number++) + L"-" +
                              std::to_wstring(std::random_device{}());
    constexpr DWORD kBytes = 1 << 16;
    Handle reads = checked(CreateNamedPipeW(
        name.c_str(), PIPE_ACCESS_INBOUND | FILE_FLAG_OVERLAPPED | FILE_FLAG_FIRST_PIPE_INSTANCE,
        PIPE_TYPE_BYTE | PIPE_WAIT | PIPE_REJECT_REMOTE_CLIENTS, 1, 0, kBytes, 0, nullptr));
    Handle writes =
        checked(CreateFileW(name.c_str(), GENERIC_WRITE, 0, &inherited, OPEN_EXISTING, 0, nullptr));
    return {std::move(reads), std::move(writes)};
}

/// A job that limits its process, and ends it when the job is closed, even if the host crashes.
Handle make_job() {
    Handle job = checked(CreateJobObjectW(nullptr, nullptr));
    JOBOBJECT_EXTENDED_LIMIT_INFORMATION limits{};
    limits.BasicLimitInformation.LimitFlags =
        JOB_OBJECT_LIMIT_KILL_ON_JOB_CLOSE | JOB_OBJECT_LIMIT_DIE_ON_UNHANDLED_EXCEPTION |
        JOB_OBJECT_LIMIT_ACTIVE_PROCESS | JOB_OBJECT_LIMIT_PROCESS_TIME |
        JOB_OBJECT_LIMIT_PROCESS_MEMORY;
    limits.BasicLimitInformation.ActiveProcessLimit = 1;
    limits.BasicLimitInformation.PerProcessUserTimeLimit.QuadPart =
        std::int64_t{10'000'000} * kContainedTime_s;
    limits.ProcessMemoryLimit = kContainedMemory_bytes;
    // Optional, as on other systems: an older Windows or another job of the host may refuse some.
    SetInformationJobObject(job.get(), JobObjectExtendedLimitInformation, &limits, sizeof(limits));
    return job;
}

/// The handles that the process inherits, of all that the host may let its processes inherit.
class InheritedHandles {
 public:
    explicit InheritedHandles(std::array<HANDLE, 3> handles) : handles_(handles) {
        SIZE_T size = 0;
        InitializeProcThreadAttributeList(nullptr, 1, 0, &size);
        memory_.resize(size);
        if (InitializeProcThreadAttributeList(list(), 1, 0, &size) == 0) fail_start();
        if (UpdateProcThreadAttribute(list(), 0, PROC_THREAD_ATTRIBUTE_HANDLE_LIST, handles_.data(),
                                      sizeof(handles_), nullptr, nullptr) == 0)
            fail_start();
    }
    ~InheritedHandles() { DeleteProcThreadAttributeList(list()); }

    LPPROC_THREAD_ATTRIBUTE_LIST list() {
        return reinterpret_cast<LPPROC_THREAD_ATTRIBUTE_LIST>(memory_.data());
    }

 private:
    std::array<HANDLE, 3> handles_;
    std::vector<std::byte> memory_;
};

}  // namespace

std::filesystem::path beside_binary(const std::filesystem::path& file) {
    HMODULE binary = nullptr;
    GetModuleHandleExW(
        GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS | GET_MODULE_HANDLE_EX_FLAG_UNCHANGED_REFCOUNT,
        reinterpret_cast<const wchar_t*>(&beside_binary), &binary);
    std::wstring name(MAX_PATH, L'\0');
    while (GetModuleFileNameW(binary, name.data(), static_cast<DWORD>(name.size())) == name.size())
        name.resize(2 * name.size());
    return std::filesystem::path(name.c_str()).replace_filename(file);
}

const char* const ChildProcess::kNeeds =
    "the program that reads it in the folder of the program or of the library";

struct ChildProcess::State {
    static constexpr std::size_t kBuffer_bytes = std::size_t{1} << 16;

    Handle job;
    Handle process;
    Handle output;
    Handle arrived{CreateEventW(nullptr, TRUE, FALSE, nullptr)};
    OVERLAPPED reading{};
    bool is_reading = false;
    bool is_complete = false;  ///< the answer has ended
    std::vector<std::byte> buffer = std::vector<std::byte>(kBuffer_bytes);
    std::size_t begin = 0;  ///< of what has arrived
    std::size_t end = 0;

    void finish_reading(bool wait) {
        DWORD got = 0;
        if (GetOverlappedResult(output.get(), &reading, &got, wait ? TRUE : FALSE) == 0 || got == 0)
            is_complete = true;
        is_reading = false;
        begin = 0;
        end = got;
    }
};

ChildProcess::ChildProcess(const ContainedProgram& program, const Descriptor& input)
    : state_(std::make_unique<State>()) {
    auto [reads, writes] = make_pipe();
    state_->output = std::move(reads);
    state_->job = make_job();
    HANDLE duplicate = nullptr;
    if (DuplicateHandle(GetCurrentProcess(),
                        reinterpret_cast<HANDLE>(_get_osfhandle(input.number())),
                        GetCurrentProcess(), &duplicate, GENERIC_READ, TRUE, 0) == 0)
        fail_start();
    const Handle file(duplicate);
    const Handle nowhere =
        checked(CreateFileW(L"NUL", GENERIC_WRITE, FILE_SHARE_READ | FILE_SHARE_WRITE, &inherited,
                            OPEN_EXISTING, 0, nullptr));
    InheritedHandles handles({file.get(), writes.get(), nowhere.get()});
    STARTUPINFOEXW start{};
    start.StartupInfo.cb = sizeof(start);
    start.StartupInfo.dwFlags = STARTF_USESTDHANDLES;
    start.StartupInfo.hStdInput = file.get();
    start.StartupInfo.hStdOutput = writes.get();
    start.StartupInfo.hStdError = nowhere.get();
    start.lpAttributeList = handles.list();
    const auto* const path = std::get_if<std::filesystem::path>(&program);
    if (path == nullptr)
        throw std::system_error(std::make_error_code(std::errc::executable_format_error));
    std::wstring command = L"\"" + path->wstring() + L"\"";
    PROCESS_INFORMATION started{};
    if (CreateProcessW(path->c_str(), command.data(), nullptr, nullptr, TRUE,
                       CREATE_SUSPENDED | CREATE_NO_WINDOW | EXTENDED_STARTUPINFO_PRESENT, nullptr,
                       nullptr, &start.StartupInfo, &started) == 0)
        fail_start();
    state_->process = Handle(started.hProcess);
    const Handle thread(started.hThread);
    AssignProcessToJobObject(state_->job.get(), state_->process.get());
    ResumeThread(thread.get());
}

ChildProcess::~ChildProcess() {
    TerminateProcess(state_->process.get(), 1);
    WaitForSingleObject(state_->process.get(), INFINITE);
    if (!state_->is_reading) return;
    CancelIo(state_->output.get());
    state_->finish_reading(true);
}

bool ChildProcess::wait(std::chrono::nanoseconds timeout) {
    State& state = *state_;
    if (state.begin < state.end || state.is_complete) return true;
    if (!state.is_reading) {
        state.reading = {};
        state.reading.hEvent = state.arrived.get();
        if (ReadFile(state.output.get(), state.buffer.data(), State::kBuffer_bytes, nullptr,
                     &state.reading) == 0 &&
            GetLastError() != ERROR_IO_PENDING) {
            state.is_complete = true;
            return true;
        }
        state.is_reading = true;
    }
    const auto milliseconds = std::chrono::ceil<std::chrono::milliseconds>(timeout).count();
    if (WaitForSingleObject(state.arrived.get(), static_cast<DWORD>(milliseconds)) != WAIT_OBJECT_0)
        return false;
    state.finish_reading(false);
    return true;
}

std::size_t ChildProcess::read(void* bytes, std::size_t size) {
    const std::size_t got = std::min(size, state_->end - state_->begin);
    std::memcpy(bytes, state_->buffer.data() + state_->begin, got);
    state_->begin += got;
    return got;
}

std::chrono::nanoseconds ChildProcess::processor_time() const {
    FILETIME unused{};
    FILETIME kernel{};
    FILETIME user{};
    if (GetProcessTimes(state_->process.get(), &unused, &unused, &kernel, &user) == 0) return {};
    const auto steps = [](FILETIME time) {
        return std::int64_t{time.dwHighDateTime} << 32 | time.dwLowDateTime;
    };
    return std::chrono::nanoseconds(100 * (steps(kernel) + steps(user)));
}

ChildProcess::End ChildProcess::end() {
    // The pipe is closed before the process has ended.
    constexpr DWORD kEnding_ms = 1000;
    constexpr DWORD kAbort = 3;  // status of abort()
    constexpr DWORD kExceptions = 0xC0000000;
    DWORD status = 0;
    WaitForSingleObject(state_->process.get(), kEnding_ms);
    GetExitCodeProcess(state_->process.get(), &status);
    if (status == kNotMapped) return End::not_mapped;
    if (status == kOutOfMemory) return End::out_of_memory;
    if (status == ERROR_NOT_ENOUGH_QUOTA) return End::out_of_time;  // of the job
    return status == kAbort || status >= kExceptions ? End::crashed : End::early;
}

}  // namespace aula
