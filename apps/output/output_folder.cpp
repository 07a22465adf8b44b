#include "apps/output/output_folder.h"

#include <algorithm>
#include <system_error>

#include "aula/exception.h"
#include "process/files.h"

namespace aula {

namespace {

namespace fs = std::filesystem;

bool has_entry(const fs::path& name) {
    std::error_code ignored;
    return fs::exists(fs::symlink_status(name, ignored));
}

/// A hidden name beside a folder, which no other program uses. It is not shortened: folders with
/// long names would share it.
fs::path beside(const fs::path& folder, const std::string& extension) {
    return folder.parent_path() / (".aula-" + folder.filename().string() + extension);
}

/// The name of a folder without "." and a slash at the end, and without ".." behind a name.
fs::path normal_name(const fs::path& folder) {
    const auto climbs = [](const fs::path& name) {
        return std::count(name.begin(), name.end(), fs::path(".."));
    };
    fs::path name = folder.lexically_normal();
    // What ".." means behind a link is not in the name.
    if (std::error_code error; climbs(name) != climbs(folder)) {
        const fs::path resolved = fs::weakly_canonical(folder, error);
        name = error ? folder : resolved;
    }
    return name.has_filename() ? name : name.parent_path();
}

/// Whether a folder has the hidden name. Throws InputError if anything else has it.
bool has_hidden_folder(const fs::path& hidden) {
    if (!has_entry(hidden)) return false;
    if (fs::is_directory(fs::symlink_status(hidden))) return true;
    throw InputError(hidden.string(), "",
                     "is not a folder; expected the unfinished folder of a killed process, or "
                     "nothing (move it away)");
}

}  // namespace

OutputFolder::OutputFolder(const fs::path& folder)
    : folder_(normal_name(folder)),
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
    for (const fs::path& hidden : {part_, earlier_}) has_hidden_folder(hidden);
    for (fs::path f = folder_.parent_path(); !f.empty() && !has_entry(f); f = f.parent_path())
        parents_.push_back(f);
    if (!parents_.empty()) fs::create_directories(parents_.front());
    fs::create_directory(part_);
    lock_.emplace(part_);
    for (const auto& left : fs::directory_iterator(part_)) fs::remove_all(left.path());
    // A process has ended between the renamings of replace().
    const bool has_earlier = has_hidden_folder(earlier_);
    if (has_earlier && has_entry(folder_))
        fs::remove_all(earlier_);
    else if (has_earlier)
        rename_flushed(earlier_, folder_);
    replaces_ = has_entry(folder_);
    // From now on: unfinished files have no other readers than the earlier ones, and new files
    // belong to the group of a folder with S_ISGID.
    if (replaces_) copy_folder_permissions(part_, folder_, true);
}

void OutputFolder::remove_part() noexcept {
    std::error_code ignored;
    if (lock_) fs::remove_all(part_, ignored);
    for (const fs::path& parent : parents_) fs::remove(parent, ignored);
}

void OutputFolder::replace() {
    // Until it is removed the earlier folder must not pass for one that a killed process has left.
    const FolderLock lock(folder_);
    copy_folder_permissions(part_, folder_, false);
    fs::path removed = part_;
    if (!exchange_names(part_, folder_)) {
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

/// Throws Failure if the name is taken.
void OutputFolder::rename_new() {
    if (!rename_to_free_name(part_, folder_)) {
        parents_.clear();
        lock_.reset();  // keeps the folder
        throw Failure(folder_.string() +
                      ": another program has created it meanwhile; the files are in " +
                      part_.string());
    }
    flush_names(folder_.parent_path());
}

void OutputFolder::commit() {
    try {
        flush_files(part_);
        if (replaces_ && has_entry(folder_))
            replace();
        else
            rename_new();
    } catch (const std::system_error& error) {
        throw Failure(folder_.string() + ": cannot write: " + error.code().message());
    }
    parents_.clear();
    lock_.reset();  // from here on part_ may be another process's folder
}

}  // namespace aula
