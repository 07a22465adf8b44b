#include "apps/session/output_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <string>
#include <system_error>

#include "audio/error.h"
#include "engine/error.h"

namespace aula {

namespace {

[[noreturn]] void fail_writing(const std::filesystem::path& file, int error) {
    throw AudioFailure(file.string() + ": cannot write: " + std::generic_category().message(error));
}

}  // namespace

OutputFile::OutputFile(std::filesystem::path file) : file_(std::move(file)), descriptor_(-1) {
    if (std::filesystem::is_directory(file_))
        throw Error(file_.string(), "", "is a directory; expected the name of a file to write");
    if (std::filesystem::is_symlink(file_)) file_ = std::filesystem::weakly_canonical(file_);
    // A device or a pipe cannot be replaced by a file of ours: it is written as it goes.
    in_place_ = std::filesystem::exists(file_) && !std::filesystem::is_regular_file(file_);
    temporary_ = in_place_
                     ? file_
                     : std::filesystem::path(file_.string() + ".part-" + std::to_string(getpid()));
    descriptor_ = open(temporary_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (descriptor_ < 0)
        throw Error(file_.string(), "",
                    std::string("cannot be written, ") + std::generic_category().message(errno) +
                        "; expected a place to write to");
}

OutputFile::~OutputFile() {
    if (descriptor_ >= 0) close(descriptor_);
    if (!committed_ && !in_place_) unlink(temporary_.c_str());
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
    const int closed = close(descriptor_);
    descriptor_ = -1;
    if (closed != 0) fail_writing(file_, errno);
    if (!in_place_ && std::rename(temporary_.c_str(), file_.c_str()) != 0)
        fail_writing(file_, errno);
    committed_ = true;
}

}  // namespace aula
