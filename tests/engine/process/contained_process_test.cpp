#include "engine/process/contained_process.h"

#include <fcntl.h>
#include <linux/landlock.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "aula/exception.h"
#include "tests/support/temporary_folder.h"

namespace {

using Catch::Contains;

std::vector<std::byte> bytes_of(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    const std::vector<char> read{std::istreambuf_iterator<char>(in), {}};
    const auto* first = reinterpret_cast<const std::byte*>(read.data());
    return {first, first + read.size()};
}

/// What contained_attempts.cpp answers, or the error if it is ended.
struct Attempt {
    std::int32_t answer = -1;
    std::string error;
};

Attempt attempted(const std::string& limits, const std::string& what) {
    static const std::vector<std::byte> program = bytes_of(AULA_CONTAINED_ATTEMPTS);
    const aula::test::TemporaryFolder folder;
    const std::string file = (folder.path() / "file").string();
    folder.write("file", limits + " " + what + " " + file);
    Attempt attempt;
    try {
        aula::ContainedProcess process(program, file, "a file");
        process.read(attempt.answer);
    } catch (const aula::InputError& error) {
        attempt.error = error.what();
        CHECK(attempt.error.starts_with(file + ": is damaged and cannot be read: "));
        CHECK(attempt.error.ends_with("; expected a file"));
        CHECK(attempt.error.find('\n') == std::string::npos);
    }
    CHECK_FALSE(std::filesystem::exists(file + ".new"));
    CHECK(std::filesystem::is_empty(file + ".written"));
    return attempt;
}

bool kernel_filters_calls() { return prctl(PR_GET_SECCOMP) >= 0; }

bool kernel_has_landlock() {
    return syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION) > 0;
}

}  // namespace

TEST_CASE("an answer that ends early is reported when the program ends, not at its deadline") {
    const aula::test::TemporaryFolder folder;
    const std::filesystem::path file = folder.write("file", "all nothing");
    aula::ContainedProcess process(bytes_of(AULA_CONTAINED_ATTEMPTS), file, "a file");
    std::int32_t answer = -1;
    process.read(answer);
    CHECK(answer == 0);
    double value = 0;
    CHECK_THROWS_WITH(process.read(value), Contains("ends before its answer is complete"));
}

TEST_CASE("a contained program may be a file, and without the file it is a failure") {
    const aula::test::TemporaryFolder folder;
    const std::filesystem::path file = folder.write("file", "all nothing");
    const std::filesystem::path program = AULA_CONTAINED_ATTEMPTS;
    aula::ContainedProcess process(program, file, "a file");
    std::int32_t answer = -1;
    process.read(answer);
    CHECK(answer == 0);
    CHECK_THROWS_AS(aula::ContainedProcess(folder.path() / "none", file, "a file"), aula::Failure);
}

TEST_CASE("a contained program answers, and opens no file") {
    CHECK(attempted("all", "nothing").answer == 0);
    const int forbidden = kernel_filters_calls() || kernel_has_landlock() ? EACCES : EMFILE;
    CHECK(attempted("all", "open").answer == forbidden);
    CHECK(attempted("all", "create").answer == forbidden);
}

TEST_CASE("a contained program that makes another system call is ended, and the error says so") {
    if (!kernel_filters_calls()) {
        WARN("skipped: the kernel has no seccomp");
        return;
    }
    for (const char* what :
         {"read", "write", "socket", "fork", "execute", "trace", "signal", "code", "descriptors"}) {
        CAPTURE(what);
        CHECK_THAT(attempted("all", what).error,
                   Contains("makes a system call that is forbidden to it"));
        // The same call succeeds or fails without the filter, and does not end the program.
        if (std::string(what) != "execute" && std::string(what) != "write")
            CHECK(attempted("files", what).error.empty());
    }
}

TEST_CASE("a contained program that needs too much memory or time, or crashes, is an error") {
    CHECK_THAT(attempted("all", "memory").error, Contains("needs more than 1 GiB of memory"));
    CHECK_THAT(attempted("all", "compute").error, Contains("computes for 5 s without an answer"));
    CHECK_THAT(attempted("all", "crash").error, Contains("crashes"));
    CHECK_THAT(attempted("all", "abort").error, Contains("crashes"));
}

TEST_CASE("each limit of a contained program holds without the others") {
    CHECK(attempted("none", "open").answer == 0);
    CHECK(attempted("none", "memory").answer == 0);
    // No new descriptor, no longer file, 1 s of processor time, and memory.
    CHECK(attempted("resources", "open").answer == EMFILE);
    CHECK(attempted("resources", "create").answer == EMFILE);
    CHECK_THAT(attempted("resources", "write").error, Contains("crashes"));  // SIGXFSZ
    CHECK_THAT(attempted("resources", "compute").error,
               Contains("needs more processor time than it may take"));
    CHECK_THAT(attempted("resources", "memory").error, Contains("needs more than 1 GiB of memory"));
    if (kernel_has_landlock()) {
        CHECK(attempted("files", "open").answer == EACCES);
        CHECK(attempted("files", "create").answer == EACCES);
    }
    if (kernel_filters_calls()) {
        CHECK(attempted("calls", "open").answer == EACCES);
        CHECK(attempted("calls", "create").answer == EACCES);
    }
}

TEST_CASE("a contained program has no descriptor of the host") {
    const aula::test::TemporaryFolder folder;
    // Child processes inherit it, because it has not O_CLOEXEC.
    const int inherited = open(folder.write("document", "text").c_str(), O_RDWR);
    REQUIRE(inherited >= 0);
    CHECK(attempted("none", "descriptors").answer > 0);
    CHECK(attempted("descriptors", "descriptors").answer == 0);
    close(inherited);
}

// This program's RUNPATH is $ORIGIN/beside.
TEST_CASE("a contained program has no environment but the folders of the host's libraries") {
    const char* const folders = std::getenv("LD_LIBRARY_PATH");
    const std::string before = folders != nullptr ? folders : "";
    setenv("LD_PRELOAD_OF_A_HOST", "library", 1);
    unsetenv("LD_LIBRARY_PATH");
    CHECK(attempted("none", "environment").answer == 1);
    CHECK(attempted("none", "library-folders").answer == 1);
    setenv("LD_LIBRARY_PATH", ("/none:" + before).c_str(), 1);
    CHECK(attempted("none", "environment").answer == 1);
    CHECK(attempted("none", "library-folders").answer >= 3);
    if (folders == nullptr) {
        unsetenv("LD_LIBRARY_PATH");
    } else {
        setenv("LD_LIBRARY_PATH", before.c_str(), 1);
    }
}

TEST_CASE("a file that is larger than the address space is an error, not an empty file") {
    const int large = memfd_create("large", MFD_CLOEXEC);
    REQUIRE(ftruncate(large, off_t{1} << 60) == 0);
    const std::string file = "/proc/self/fd/" + std::to_string(large);
    aula::ContainedProcess process(bytes_of(AULA_CONTAINED_ATTEMPTS), file, "a file");
    char answer = 0;
    CHECK_THROWS_WITH(process.read(answer),
                      file + ": cannot be mapped into memory; expected a file");
    close(large);
}
