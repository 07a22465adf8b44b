#include "audio/part_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <mutex>
#include <string>
#include <system_error>
#include <utility>

namespace aula {

namespace {

// A program that is told to end at once has to find them all.
std::mutex mutex;
PartFile* first = nullptr;

[[noreturn]] void fail(int error) { throw std::system_error(error, std::generic_category()); }

}  // namespace

PartFile::PartFile(const std::filesystem::path& file) {
    std::error_code error;
    target_ = std::filesystem::weakly_canonical(file, error);
    if (error) target_ = file;
    temporary_ = target_;
    temporary_ += "." + std::to_string(getpid()) + ".part";
    const std::lock_guard lock(mutex);
    descriptor_ = open(temporary_.c_str(), O_CREAT | O_TRUNC | O_RDWR | O_CLOEXEC, 0666);
    if (descriptor_ < 0) fail(errno);
    next_ = std::exchange(first, this);
}

PartFile::~PartFile() {
    const std::lock_guard lock(mutex);
    PartFile** place = &first;
    while (*place != this) place = &(*place)->next_;
    *place = next_;
    if (descriptor_ >= 0) close(descriptor_);
    if (!temporary_.empty()) unlink(temporary_.c_str());
}

void PartFile::commit() {
    if (close(std::exchange(descriptor_, -1)) != 0) fail(errno);
    const std::lock_guard lock(mutex);
    if (std::rename(temporary_.c_str(), target_.c_str()) != 0) fail(errno);
    temporary_.clear();
}

void PartFile::abandon_all() {
    mutex.lock();
    for (const PartFile* file = first; file != nullptr; file = file->next_)
        unlink(file->temporary_.c_str());
}

}  // namespace aula
