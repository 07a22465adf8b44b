#include "apps/session/base/output_folder.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <system_error>
#include <utility>

#include "audio/file/naming.h"
#include "aula/exception.h"

namespace aula {

namespace {

namespace fs = std::filesystem;

bool has_entry(const fs::path& name) {
    std::error_code ignored;
    return fs::exists(fs::symlink_status(name, ignored));
}

/// A hidden name beside a folder.
fs::path beside(const fs::path& folder, const std::string& extension) {
    constexpr std::size_t kLongestName = 255;
    const std::string name =
        folder.filename().string().substr(0, kLongestName - 1 - extension.size());
    return folder.parent_path() / ("." + name + extension);
}

fs::path without_slash(fs::path folder) {
    return folder.has_filename() ? std::move(folder) : folder.parent_path();
}

/// Flushes all files of the folder's file system to the disk: one by one takes longer.
void flush_files(const fs::path& folder) {
    const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    const bool flushed = descriptor >= 0 && syncfs(descriptor) == 0;
    const std::error_code error(errno, std::generic_category());
    if (descriptor >= 0) close(descriptor);
    if (!flushed) throw std::system_error(error);
}

}  // namespace

OutputFolder::OutputFolder(fs::path folder)
    : folder_(without_slash(std::move(folder))),
      part_(beside(folder_, ".part")),
      earlier_(beside(folder_, ".old")) {
    try {
        prepare();
    } catch (const std::system_error& error) {
        remove_part();
        throw InputError(folder_.string(), "",
                         "cannot be created, " + error.code().message() +
                             "; expected a folder in which files can be written");
    }
}

OutputFolder::~OutputFolder() { remove_part(); }

void OutputFolder::prepare() {
    for (fs::path f = folder_.parent_path(); !f.empty() && !has_entry(f); f = f.parent_path())
        parents_.push_back(f);
    if (!parents_.empty()) fs::create_directories(parents_.front());
    if (!fs::is_directory(fs::symlink_status(part_))) fs::remove(part_);
    fs::create_directory(part_);
    lock_.emplace(part_);
    for (const auto& left : fs::directory_iterator(part_)) fs::remove_all(left.path());
    if (!has_entry(earlier_)) return;
    // A process has ended between the renamings of replace().
    if (has_entry(folder_))
        fs::remove_all(earlier_);
    else
        rename_flushed(earlier_, folder_);
}

void OutputFolder::remove_part() noexcept {
    std::error_code ignored;
    if (lock_) fs::remove_all(part_, ignored);
    for (const fs::path& parent : parents_) fs::remove(parent, ignored);
}

void OutputFolder::replace() {
    // Until it is removed the earlier folder must not pass for one that a killed process has left.
    const FolderLock lock(folder_);
    fs::path removed = part_;
    if (renameat2(AT_FDCWD, part_.c_str(), AT_FDCWD, folder_.c_str(), RENAME_EXCHANGE) != 0) {
        // The file system or the kernel cannot exchange names. A process that ends in between
        // leaves the earlier folder for prepare().
        fs::rename(folder_, earlier_);
        std::error_code error;
        fs::rename(part_, folder_, error);
        if (error) {
            fs::rename(earlier_, folder_);
            throw std::system_error(error);
        }
        removed = earlier_;
    }
    flush_names(folder_.parent_path());
    fs::remove_all(removed);
}

void OutputFolder::commit() {
    try {
        flush_files(part_);
        if (has_entry(folder_))
            replace();
        else
            rename_flushed(part_, folder_);
    } catch (const std::system_error& error) {
        throw Failure(folder_.string() + ": cannot write: " + error.code().message());
    }
    parents_.clear();
    lock_.reset();  // from here on part_ may be another process's folder
}

}  // namespace aula
