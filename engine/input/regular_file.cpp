#include "engine/input/regular_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "aula/exception.h"

namespace aula {
namespace {

class Descriptor {
 public:
    // Non-blocking: opening a pipe does not wait for its other end.
    explicit Descriptor(const std::filesystem::path& file)
        : fd_(::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY)) {}
    ~Descriptor() {
        if (fd_ >= 0) ::close(fd_);
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;

    int get() const { return fd_; }

 private:
    int fd_;
};

[[noreturn]] void fail(const char* what) {
    throw InputError(std::string(what) + ", " + std::strerror(errno) +
                     "; expected a readable file");
}

}  // namespace

std::string read_regular_file(const std::filesystem::path& file, std::uint64_t max_bytes) {
    constexpr const char* kOtherKind = "it is not a regular file; expected one";
    const Descriptor descriptor(file);
    if (descriptor.get() < 0) {
        if (errno == ENXIO) throw InputError(kOtherKind);  // a socket
        fail("it cannot be opened");
    }
    struct stat status {};
    if (::fstat(descriptor.get(), &status) != 0) fail("it cannot be opened");
    if (!S_ISREG(status.st_mode)) throw InputError(kOtherKind);
    const auto size = static_cast<std::uint64_t>(status.st_size);
    if (size > max_bytes) {
        throw InputError("it holds " + std::to_string(size) + " bytes; expected at most " +
                         std::to_string(max_bytes));
    }
    std::string bytes(size, '\0');
    std::size_t done = 0;
    while (done < bytes.size()) {
        const ssize_t count = ::read(descriptor.get(), bytes.data() + done, bytes.size() - done);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) fail("it cannot be read");
        if (count == 0) break;
        done += static_cast<std::size_t>(count);
    }
    bytes.resize(done);
    return bytes;
}

}  // namespace aula
