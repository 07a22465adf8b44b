#include "audio/file/part_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <csignal>
#include <filesystem>
#include <functional>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "aula/exception.h"
#include "tests/support/program.h"
#include "tests/support/temporary_folder.h"

namespace {

using namespace aula;
using test::names_in;
using test::read_file;
using test::TemporaryFolder;

void write_part(const std::filesystem::path& file, const std::string& text) {
    PartFile part(file);
    REQUIRE(write(part.descriptor(), text.data(), text.size()) ==
            static_cast<ssize_t>(text.size()));
    part.commit();
}

/// Called in place of fsync() of the C library, if it is set.
std::function<int(int)> observe_fsync;

mode_t permissions(const std::filesystem::path& file) {
    struct stat status {};
    REQUIRE(stat(file.c_str(), &status) == 0);
    return status.st_mode & 0777U;
}

}  // namespace

extern "C" int fsync(int descriptor) {
    return observe_fsync ? observe_fsync(descriptor)
                         : static_cast<int>(syscall(SYS_fsync, descriptor));
}

TEST_CASE("A file is on the disk before it replaces another, which stays if that fails") {
    const TemporaryFolder folder;
    const auto file = folder.write("file", "before");
    int calls = 0;
    observe_fsync = [&](int descriptor) {
        ++calls;
        struct stat status {};
        CHECK(fstat(descriptor, &status) == 0);
        if (calls == 1) {
            CHECK(status.st_size == 5);
            CHECK(read_file(file) == "before");
        } else {
            // Then its new name.
            struct stat parent {};
            CHECK(stat(folder.path().c_str(), &parent) == 0);
            CHECK(status.st_ino == parent.st_ino);
            CHECK(read_file(file) == "after");
        }
        return 0;
    };
    write_part(file, "after");
    CHECK(calls == 2);
    CHECK(read_file(file) == "after");
    observe_fsync = [](int) {
        errno = EIO;
        return -1;
    };
    CHECK_THROWS_AS(write_part(file, "never"), std::system_error);
    observe_fsync = nullptr;
    CHECK(read_file(file) == "after");
    CHECK(names_in(folder.path()) == std::vector<std::string>{"file"});
}

TEST_CASE("A program that exits while the disk is slow keeps a complete file") {
    const TemporaryFolder folder;
    const auto complete = folder.write("complete", "before");
    const auto unfinished = folder.write("unfinished", "before");
    const pid_t child = fork();
    REQUIRE(child >= 0);
    if (child == 0) {
        observe_fsync = [](int) -> int {
            PartFile::abandon_all();
            _exit(0);
        };
        const PartFile other(unfinished);
        write_part(complete, "after");
        _exit(1);
    }
    int status = -1;
    REQUIRE(waitpid(child, &status, 0) == child);
    CHECK(status == 0);
    CHECK(read_file(complete) == "after");
    CHECK(read_file(unfinished) == "before");
    CHECK(names_in(folder.path()) == std::vector<std::string>{"complete", "unfinished"});
}

TEST_CASE("A replaced file keeps its permissions, a new one has the user's defaults") {
    const TemporaryFolder folder;
    const auto old_file = folder.write("old", "before");
    const mode_t mode = GENERATE(0600U, 0640U, 0666U);
    REQUIRE(chmod(old_file.c_str(), mode) == 0);
    write_part(old_file, "after");
    CHECK(read_file(old_file) == "after");
    CHECK(permissions(old_file) == mode);

    const mode_t before = umask(0027);
    write_part(folder.path() / "new", "new");
    umask(before);
    CHECK(permissions(folder.path() / "new") == 0640U);
    CHECK(names_in(folder.path()) == std::vector<std::string>{"new", "old"});
}

TEST_CASE("A symbolic link prepared at the name of a temporary file is not followed") {
    const TemporaryFolder folder;
    const auto victim = folder.write("victim", "mine");
    const auto target = folder.path() / "out";
    // Predictable names: one from the process id, and one without randomness.
    std::filesystem::create_symlink(victim,
                                    target.string() + "." + std::to_string(getpid()) + ".part");
    std::filesystem::create_symlink(victim, folder.path() / ".aula-0000000000000000.part");
    write_part(target, "new");
    CHECK(read_file(victim) == "mine");
    CHECK(read_file(target) == "new");
    CHECK_FALSE(std::filesystem::is_symlink(target));
}

TEST_CASE("The target of a symbolic link is replaced, not the link") {
    const TemporaryFolder folder;
    const auto file = folder.write("file", "before");
    std::filesystem::create_symlink("file", folder.path() / "link");
    write_part(folder.path() / "link", "after");
    CHECK(std::filesystem::is_symlink(folder.path() / "link"));
    CHECK(read_file(file) == "after");
}

TEST_CASE("The target of a link that points to nothing is created, and the link stays") {
    const TemporaryFolder folder;
    std::filesystem::create_directory(folder.path() / "sub");
    std::filesystem::create_symlink("sub/new", folder.path() / "near");
    std::filesystem::create_symlink(folder.path() / "near", folder.path() / "far");
    write_part(folder.path() / "far", "new");
    CHECK(read_file(folder.path() / "sub/new") == "new");
    for (const char* link : {"near", "far"})
        CHECK(std::filesystem::is_symlink(folder.path() / link));
    CHECK(names_in(folder.path() / "sub") == std::vector<std::string>{"new"});
}

TEST_CASE("A file has one name behind links, whether or not it exists") {
    const TemporaryFolder folder;
    const auto before = std::filesystem::current_path();
    std::filesystem::current_path(folder.path());
    for (int exists = 0; exists < 2; ++exists) {
        const auto file = file_behind_links("file");
        CHECK(file == std::filesystem::canonical(folder.path()) / "file");
        CHECK(file_behind_links("./file") == file);
        CHECK(file_behind_links("none/../file") == file);
        CHECK(file_behind_links(folder.path() / "file") == file);
        folder.write("file", "");
    }
    std::filesystem::current_path(before);
}

TEST_CASE("Links that form a loop or lead to no folder, and names too long, are refused") {
    const TemporaryFolder folder;
    std::filesystem::create_symlink("b", folder.path() / "a");
    std::filesystem::create_symlink("a", folder.path() / "b");
    std::filesystem::create_symlink("nowhere/file", folder.path() / "c");
    const auto before = names_in(folder.path());
    for (const std::string& name : {std::string("a"), std::string("c"), std::string(256, 'n')}) {
        CAPTURE(name);
        CHECK_THROWS_AS(PartFile(folder.path() / name), std::system_error);
    }
    CHECK(names_in(folder.path()) == before);
    for (const char* link : {"a", "b", "c"})
        CHECK(std::filesystem::is_symlink(folder.path() / link));
}

TEST_CASE("A file with the longest possible name can be written twice at the same time") {
    const TemporaryFolder folder;
    const auto file = folder.path() / std::string(255, 'n');
    {
        const PartFile first(file);
        write_part(file, "second");
        CHECK(names_in(folder.path()).size() == 2);
    }
    CHECK(read_file(file) == "second");
    CHECK(names_in(folder.path()).size() == 1);
}

TEST_CASE(
    "Until it is committed a file keeps its name and content, and is removed without commit") {
    const TemporaryFolder folder;
    const auto file = folder.write("file", "before");
    {
        const PartFile part(file);
        REQUIRE(write(part.descriptor(), "after", 5) == 5);
        CHECK(read_file(file) == "before");
        const auto names = names_in(folder.path());
        REQUIRE(names.size() == 2);
        CHECK(names[0].starts_with(".aula-"));
        CHECK(names[0].ends_with(".part"));
    }
    CHECK(read_file(file) == "before");
    CHECK(names_in(folder.path()) == std::vector<std::string>{"file"});
}

TEST_CASE("A link to a file of another folder: the file is replaced in its own folder") {
    const TemporaryFolder folder;
    const TemporaryFolder other;
    const auto file = other.write("file", "before");
    REQUIRE(chmod(file.c_str(), 0640) == 0);
    std::filesystem::create_symlink(file, folder.path() / "near");
    std::filesystem::create_symlink("near", folder.path() / "far");
    {
        PartFile part(folder.path() / "far");
        REQUIRE(write(part.descriptor(), "after", 5) == 5);
        // In one file system with the target, or it could not be renamed.
        CHECK(names_in(other.path()).size() == 2);
        part.commit();
    }
    CHECK(read_file(file) == "after");
    CHECK(permissions(file) == 0640U);
    CHECK(names_in(folder.path()) == std::vector<std::string>{"far", "near"});
    CHECK(names_in(other.path()) == std::vector<std::string>{"file"});
    CHECK(std::filesystem::read_symlink(folder.path() / "far") == "near");
}

TEST_CASE("A file in a folder that does not exist, or is a file, is a system error") {
    const TemporaryFolder folder;
    const auto file = folder.write("file", "mine");
    for (const auto& [name, error] :
         {std::pair{folder.path() / "none" / "a", ENOENT}, {file / "a", ENOTDIR}}) {
        int code = 0;
        try {
            const PartFile part(name);
        } catch (const std::system_error& failure) {
            code = failure.code().value();
        }
        CAPTURE(name);
        CHECK(code == error);
    }
    CHECK(names_in(folder.path()) == std::vector<std::string>{"file"});
}

TEST_CASE("A commit whose folder was removed, or whose target became a folder, fails") {
    const TemporaryFolder folder;
    const auto inner = folder.path() / "inner";
    std::filesystem::create_directory(inner);
    {
        PartFile part(inner / "a");
        std::filesystem::remove_all(inner);
        CHECK_THROWS_AS(part.commit(), std::system_error);
    }
    {
        PartFile part(folder.path() / "a");
        std::filesystem::create_directory(folder.path() / "a");
        CHECK_THROWS_AS(part.commit(), std::system_error);
    }
    // Nothing is left of either.
    CHECK(names_in(folder.path()) == std::vector<std::string>{"a"});
}

TEST_CASE("Files of several threads are independent of each other") {
    const TemporaryFolder folder;
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t) {
        threads.emplace_back([&folder, t] {
            for (int i = 0; i < 10; ++i) {
                const auto name = std::to_string(10 * t + i);
                PartFile part(folder.path() / name);
                const PartFile abandoned(folder.path() / name);
                // REQUIRE is for one thread only.
                if (write(part.descriptor(), name.data(), name.size()) > 0) part.commit();
            }
        });
    }
    for (std::thread& thread : threads) thread.join();
    CHECK(names_in(folder.path()).size() == 40);
    for (int i = 0; i < 40; ++i)
        CHECK(read_file(folder.path() / std::to_string(i)) == std::to_string(i));
}

TEST_CASE("A program that abandons its files leaves none") {
    const TemporaryFolder folder;
    const pid_t child = fork();
    REQUIRE(child >= 0);
    if (child == 0) {
        const PartFile first(folder.path() / "a");
        const PartFile second(folder.path() / "b");
        const bool both = names_in(folder.path()).size() == 2;
        PartFile::abandon_all();
        _exit(both && names_in(folder.path()).empty() ? 0 : 1);
    }
    int status = -1;
    REQUIRE(waitpid(child, &status, 0) == child);
    REQUIRE(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == 0);
    CHECK(names_in(folder.path()).empty());
}

TEST_CASE("What a killed program has left is removed by the next one with the same target") {
    const TemporaryFolder folder;
    const auto killed_while_writing = [&](const char* name) {
        const pid_t child = fork();
        REQUIRE(child >= 0);
        if (child == 0) {
            const PartFile part(folder.path() / name);
            kill(getpid(), SIGKILL);
        }
        int status = -1;
        REQUIRE(waitpid(child, &status, 0) == child);
        REQUIRE(WIFSIGNALED(status));
    };
    killed_while_writing("a");
    killed_while_writing("b");
    CHECK(names_in(folder.path()).size() == 2);
    {
        // Files in use have a lock.
        const PartFile first(folder.path() / "a");
        CHECK(names_in(folder.path()).size() == 2);
        const PartFile second(folder.path() / "a");
        CHECK(names_in(folder.path()).size() == 3);
    }
    CHECK(names_in(folder.path()).size() == 1);
    write_part(folder.path() / "b", "new");
    CHECK(names_in(folder.path()) == std::vector<std::string>{"b"});
}

TEST_CASE("A file without write permission for its owner is not replaced, by root neither") {
    const TemporaryFolder folder;
    const auto file = folder.write("file", "mine");
    std::filesystem::create_symlink("file", folder.path() / "link");
    for (const mode_t mode : {0444U, 0400U, 0577U}) {
        REQUIRE(chmod(file.c_str(), mode) == 0);
        for (const char* const name : {"file", "link"})
            CHECK_THROWS_AS(PartFile(folder.path() / name), InputError);
    }
    CHECK(read_file(file) == "mine");
    CHECK(names_in(folder.path()) == std::vector<std::string>{"file", "link"});
}

TEST_CASE("Programs started meanwhile do not inherit an unfinished file") {
    const TemporaryFolder folder;
    const PartFile part(folder.path() / "a");
    CHECK((fcntl(part.descriptor(), F_GETFD) & FD_CLOEXEC) != 0);
}
