#include "process/regular_file.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "aula/exception.h"
#include "process/files.h"

namespace aula {

std::filesystem::path utf8_path(std::string_view name) {
    return std::u8string(name.begin(), name.end());
}

RegularFile::RegularFile(std::filesystem::path file, const char* expected)
    : file_(std::move(file)), expected_(expected), descriptor_(open()) {
    std::optional<std::uint64_t> size;
    try {
        size = regular_size(descriptor_.number());
    } catch (const std::system_error& error) {
        fail("cannot be opened, " + error.code().message());
    }
    // It may have been exchanged since its type was read.
    if (!size) fail("is not a regular file");
    size_ = *size;
}

Descriptor RegularFile::open() const {
    std::error_code error;
    const std::filesystem::file_status status = std::filesystem::status(file_, error);
    if (error == std::errc::no_such_file_or_directory) fail("no such file");
    if (error) fail("cannot be opened, " + error.message());
    if (std::filesystem::is_directory(status)) fail("is a folder, not a regular file");
    if (!std::filesystem::is_regular_file(status)) fail("is not a regular file");
    try {
        return Descriptor(open_to_read(file_));
    } catch (const std::system_error& failure) {
        fail("cannot be opened, " + failure.code().message());
    }
}

void RegularFile::fail(const std::string& problem) const {
    throw InputError(file_.string(), "", problem + "; expected " + expected_);
}

std::string RegularFile::read(std::uint64_t offset, std::uint64_t count) const {
    std::string bytes(offset < size_ ? std::min(count, size_ - offset) : 0, '\0');
    std::size_t done = 0;
    try {
        while (done < bytes.size()) {
            const std::size_t got = read_at(descriptor_.number(), bytes.data() + done,
                                            bytes.size() - done, offset + done);
            if (got == 0) break;
            done += got;
        }
    } catch (const std::system_error& error) {
        fail("cannot be read, " + error.code().message());
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
