#include "apps/output/output_file.h"

#include <unistd.h>

#include <string>
#include <system_error>
#include <utility>

#include "aula/exception.h"
#include "process/files.h"

namespace aula {

namespace {

[[noreturn]] void fail_writing(const std::filesystem::path& file, const std::system_error& error) {
    throw Failure(file.string() + ": cannot write: " + error.code().message());
}

}  // namespace

OutputFile::OutputFile(const std::filesystem::path& file, std::filesystem::path named)
    : file_(std::move(named)) {
    std::error_code error;
    const auto status = std::filesystem::status(file, error);
    if (std::filesystem::is_directory(status))
        throw InputError(file_.string(), "",
                         "is a directory; expected the name of a file to write");
    try {
        // A device or a pipe cannot be replaced by a new file, so it is written directly.
        if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
            descriptor_ = open_device(file);
        else
            descriptor_ = part_.emplace(file).descriptor();
    } catch (const std::system_error& failure) {
        throw InputError(
            file_.string(), "",
            "cannot be written, " + failure.code().message() + "; expected a place to write to");
    }
}

OutputFile::~OutputFile() {
    if (descriptor_ >= 0 && !part_) close(descriptor_);
}

void OutputFile::write(std::string_view text) {
    try {
        write_all(descriptor_, text);
    } catch (const std::system_error& error) {
        fail_writing(file_, error);
    }
}

void OutputFile::commit() {
    try {
        if (part_)
            part_->commit();
        else
            close_file(std::exchange(descriptor_, -1));
    } catch (const std::system_error& error) {
        fail_writing(file_, error);
    }
}

}  // namespace aula
