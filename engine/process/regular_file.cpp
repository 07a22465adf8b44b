#include "process/regular_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include "aula/exception.h"

namespace aula {

Descriptor::Descriptor(int number) : number_(number) {
    if (number_ < 0 || number_ > STDERR_FILENO) return;
    number_ = fcntl(number, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    close(number);
}

void Descriptor::reset() {
    if (number_ >= 0) close(std::exchange(number_, -1));
}

RegularFile::RegularFile(std::filesystem::path file, const char* expected)
    : file_(std::move(file)), expected_(expected), descriptor_(open()) {
    struct stat status {};
    if (descriptor_.number() < 0 || fstat(descriptor_.number(), &status) != 0)
        fail("cannot be opened, " + std::generic_category().message(errno));
    // It may have been exchanged since its type was read.
    if (!S_ISREG(status.st_mode)) fail("is not a regular file");
    size_ = static_cast<std::uint64_t>(status.st_size);
}

Descriptor RegularFile::open() const {
    struct stat status {};
    if (stat(file_.c_str(), &status) != 0) {
        if (errno == ENOENT) fail("no such file");
        fail("cannot be opened, " + std::generic_category().message(errno));
    }
    if (S_ISDIR(status.st_mode)) fail("is a folder, not a regular file");
    if (!S_ISREG(status.st_mode)) fail("is not a regular file");
    // Non-blocking: a pipe that has replaced the file does not wait for its other end.
    return Descriptor(::open(file_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
}

void RegularFile::fail(const std::string& problem) const {
    throw InputError(file_.string(), "", problem + "; expected " + expected_);
}

std::string RegularFile::read(std::uint64_t offset, std::uint64_t count) const {
    std::string bytes(offset < size_ ? std::min(count, size_ - offset) : 0, '\0');
    std::size_t done = 0;
    while (done < bytes.size()) {
        const ssize_t got = pread(descriptor_.number(), bytes.data() + done, bytes.size() - done,
                                  static_cast<off_t>(offset + done));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) fail("cannot be read, " + std::generic_category().message(errno));
        if (got == 0) break;
        done += static_cast<std::size_t>(got);
    }
    bytes.resize(done);
    return bytes;
}

std::string read_regular_file(const std::filesystem::path& file, std::uint64_t max_bytes,
                              const char* expected) {
    const RegularFile opened(file, expected);
    if (opened.size() > max_bytes)
        throw InputError(file.string(), "",
                         "holds " + std::to_string(opened.size()) + " bytes; expected at most " +
                             std::to_string(max_bytes));
    return opened.read(0, opened.size());
}

}  // namespace aula
