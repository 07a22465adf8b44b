#include "apps/dataset/base/tar.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <system_error>
#include <utility>

#include "apps/session/base/formatted.h"
#include "aula/exception.h"

namespace aula {

namespace {

constexpr std::size_t kBlock = 512;
constexpr std::size_t kNameSize = 100;
constexpr std::size_t kSizeAt = 124;
constexpr std::size_t kSizeDigits = 11;
constexpr std::size_t kChecksumAt = 148;
constexpr const char* kDamaged = "is damaged; expected a shard of aula dataset run";

std::uint64_t padding(std::uint64_t size) { return (kBlock - size % kBlock) % kBlock; }

const std::string& zeros() {
    static const std::string bytes(2 * kBlock, '\0');
    return bytes;
}

}  // namespace

std::string tar_header(const std::string& name, std::uint64_t size) {
    std::string header(kBlock, '\0');
    const auto put = [&](std::size_t at, std::string_view text) {
        std::copy(text.begin(), text.end(), header.begin() + static_cast<std::ptrdiff_t>(at));
    };
    put(0, name);
    put(100, "0000644");  // mode
    put(108, "0000000");  // user
    put(116, "0000000");  // group
    put(kSizeAt, formatted("%011llo", static_cast<unsigned long long>(size)));
    put(136, "00000000000");  // time
    put(kChecksumAt, "        ");
    put(156, "0");  // a regular file
    put(257, std::string_view("ustar\00000", 8));
    unsigned sum = 0;
    for (const char c : header) sum += static_cast<unsigned char>(c);
    put(kChecksumAt, formatted("%06o", sum));
    header[kChecksumAt + 6] = '\0';
    return header;
}

std::string_view tar_padding(std::uint64_t size) {
    return std::string_view(zeros()).substr(0, static_cast<std::size_t>(padding(size)));
}

std::string_view tar_end() { return zeros(); }

TarReader::TarReader(std::filesystem::path file)
    : file_(std::move(file)), descriptor_(open(file_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
    struct stat status {};
    if (descriptor_ < 0 || fstat(descriptor_, &status) != 0) {
        const int error = errno;
        if (descriptor_ >= 0) close(descriptor_);
        throw InputError(
            file_.string(), "",
            "cannot be opened, " + std::generic_category().message(error) + "; expected a shard");
    }
    if (!S_ISREG(status.st_mode)) {
        close(descriptor_);
        throw InputError(file_.string(), "", "is not a regular file; expected a shard");
    }
    size_ = static_cast<std::uint64_t>(status.st_size);
}

TarReader::~TarReader() { close(descriptor_); }

std::string TarReader::bytes(std::uint64_t offset, std::uint64_t count) const {
    if (offset > size_ || count > size_ - offset) throw InputError(file_.string(), "", kDamaged);
    std::string text(static_cast<std::size_t>(count), '\0');
    for (std::size_t done = 0; done < text.size();) {
        const ssize_t read = pread(descriptor_, text.data() + done, text.size() - done,
                                   static_cast<off_t>(offset + done));
        if (read < 0 && errno == EINTR) continue;
        if (read <= 0) throw InputError(file_.string(), "", kDamaged);
        done += static_cast<std::size_t>(read);
    }
    return text;
}

std::optional<TarMember> TarReader::next() {
    const std::string header = bytes(next_, kBlock);
    if (header[0] == '\0') {
        if (bytes(next_, 2 * kBlock) != tar_end()) throw InputError(file_.string(), "", kDamaged);
        return std::nullopt;
    }
    TarMember member{header.substr(0, std::min(header.find('\0'), kNameSize)), next_ + kBlock, 0};
    const char* const digits = header.data() + kSizeAt;
    std::from_chars(digits, digits + kSizeDigits, member.size, 8);
    // Only what tar_header() writes.
    if (header != tar_header(member.name, member.size))
        throw InputError(file_.string(), "", kDamaged);
    next_ = member.offset + member.size + padding(member.size);
    return member;
}

std::string TarReader::read(const TarMember& member) const {
    return bytes(member.offset, member.size);
}

}  // namespace aula
