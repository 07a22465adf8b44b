#include "process/contained_process.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "aula/exception.h"
#include "process/files.h"
#include "process/regular_file.h"

namespace aula {

namespace {

/// Limits of the processor time and of the time between two parts of the answer. The former allows
/// the largest valid file on a slow machine, the latter a busy machine or a slow disk.
constexpr std::chrono::seconds kLongestComputation{5};
constexpr std::chrono::seconds kLongest{60};

/// How the process ended.
const char* how_it_ended(ChildProcess::End end) {
    switch (end) {
        case ChildProcess::End::out_of_memory:
            return "needs more than 1 GiB of memory";
        case ChildProcess::End::forbidden_call:
            return "makes a system call that is forbidden to it";
        case ChildProcess::End::out_of_time:
            return "needs more processor time than it may take";
        case ChildProcess::End::crashed:
            return "crashes";
        default:
            return "ends before its answer is complete";
    }
}

[[noreturn]] void fail_to_start(const std::filesystem::path& file, const std::error_code& error) {
    throw Failure(file.string() + ": the process that reads it cannot be started, " +
                  error.message() + "; expected " + ChildProcess::kNeeds);
}

}  // namespace

ContainedProcess::ContainedProcess(const ContainedProgram& program, std::filesystem::path file,
                                   std::string expected)
    : file_(std::move(file)), expected_(std::move(expected)) {
    begin(program, RegularFile(file_, expected_.c_str()).descriptor());
}

ContainedProcess::ContainedProcess(const ContainedProgram& program, std::string_view bytes,
                                   std::filesystem::path name, std::string expected)
    : file_(std::move(name)), expected_(std::move(expected)) {
    try {
        begin(program, anonymous_file(bytes));
    } catch (const std::system_error& error) {
        fail_to_start(file_, error.code());
    }
}

/// Starts the process.
void ContainedProcess::begin(const ContainedProgram& program, const Descriptor& input) {
    try {
        process_.emplace(program, input);
    } catch (const std::system_error& error) {
        fail_to_start(file_, error.code());
    }
    answered_ = Clock::now();
}

void ContainedProcess::refuse_as_ended() {
    const ChildProcess::End end = process_->end();
    if (end == ChildProcess::End::not_mapped) refuse("cannot be mapped into memory");
    refuse_as_damaged(how_it_ended(end));
}

void ContainedProcess::refuse_as_damaged(const std::string& how) const {
    refuse("is damaged and cannot be read: the process that reads it " + how);
}

void ContainedProcess::refuse(const std::string& problem) const {
    throw InputError(file_.string() + ": " + problem + "; expected " + expected_);
}

void ContainedProcess::wait_for_answer() {
    std::chrono::nanoseconds left{0};
    while (!process_->wait(left)) {
        const auto waited = Clock::now() - answered_;
        const auto computed = process_->processor_time() - computed_;
        if (computed >= kLongestComputation)
            refuse_as_damaged("computes for 5 s without an answer");
        if (waited >= kLongest) refuse_as_damaged("gives no answer for 60 s");
        // The process has one thread: its processor time passes no faster than time.
        left =
            std::min<std::chrono::nanoseconds>(kLongestComputation - computed, kLongest - waited);
    }
}

void ContainedProcess::read_bytes(void* bytes, std::size_t size) {
    auto* to = static_cast<std::byte*>(bytes);
    while (size > 0) {
        wait_for_answer();
        const std::size_t got = process_->read(to, size);
        if (got == 0) refuse_as_ended();
        to += got;
        size -= got;
    }
    answered_ = Clock::now();
    computed_ = process_->processor_time();
}

}  // namespace aula
