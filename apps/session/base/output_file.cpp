#include "apps/session/base/output_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include "aula/exception.h"

namespace aula {

namespace {

[[noreturn]] void fail_writing(const std::filesystem::path& file, int error) {
    throw Failure(file.string() + ": cannot write: " + std::generic_category().message(error));
}

[[noreturn]] void refuse(const std::filesystem::path& file, int error) {
    throw InputError(file.string(), "",
                     "cannot be written, " + std::generic_category().message(error) +
                         "; expected a place to write to");
}

}  // namespace

OutputFile::OutputFile(const std::filesystem::path& file, std::filesystem::path named)
    : file_(std::move(named)) {
    std::error_code error;
    const auto status = std::filesystem::status(file, error);
    if (std::filesystem::is_directory(status))
        throw InputError(file_.string(), "",
                         "is a directory; expected the name of a file to write");
    // A device or a pipe cannot be replaced by a new file, so it is written directly.
    if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
        descriptor_ = open(file.c_str(), O_WRONLY | O_CLOEXEC);
        if (descriptor_ < 0) refuse(file_, errno);
        return;
    }
    try {
        part_.emplace(file);
    } catch (const std::system_error& failure) {
        refuse(file_, failure.code().value());
    }
    descriptor_ = part_->descriptor();
}

OutputFile::~OutputFile() {
    if (descriptor_ >= 0 && !part_) close(descriptor_);
}

void OutputFile::write(std::string_view text) {
    while (!text.empty()) {
        const ssize_t written = ::write(descriptor_, text.data(), text.size());
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) fail_writing(file_, errno);
        text.remove_prefix(static_cast<std::size_t>(written));
    }
}

void OutputFile::commit() {
    if (!part_) {
        if (close(std::exchange(descriptor_, -1)) != 0) fail_writing(file_, errno);
        return;
    }
    try {
        part_->commit();
    } catch (const std::system_error& error) {
        fail_writing(file_, error.code().value());
    }
}

}  // namespace aula
