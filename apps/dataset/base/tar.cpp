#include "apps/dataset/base/tar.h"

#include <algorithm>
#include <array>
#include <charconv>

#include "apps/output/formatted.h"
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

TarReader::TarReader(const std::filesystem::path& file)
    : name_(file.string()), file_(file, "a shard") {}

std::string TarReader::bytes(std::uint64_t offset, std::uint64_t count) const {
    std::string text = file_.read(offset, count);
    if (text.size() != count) throw InputError(name_, "", kDamaged);
    return text;
}

std::optional<TarMember> TarReader::next() {
    const std::string header = bytes(next_, kBlock);
    if (header[0] == '\0') {
        if (bytes(next_, 2 * kBlock) != tar_end()) throw InputError(name_, "", kDamaged);
        return std::nullopt;
    }
    TarMember member{header.substr(0, std::min(header.find('\0'), kNameSize)), next_ + kBlock, 0};
    const char* const digits = header.data() + kSizeAt;
    std::from_chars(digits, digits + kSizeDigits, member.size, 8);
    // Only what tar_header() writes.
    if (header != tar_header(member.name, member.size)) throw InputError(name_, "", kDamaged);
    next_ = member.offset + member.size + padding(member.size);
    return member;
}

std::string TarReader::read(const TarMember& member) const {
    return bytes(member.offset, member.size);
}

}  // namespace aula
