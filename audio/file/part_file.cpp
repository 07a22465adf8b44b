#include "audio/file/part_file.h"

#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <mutex>
#include <optional>
#include <random>
#include <string>
#include <system_error>
#include <utility>

#include "process/files.h"

namespace aula {

namespace {

// List of all PartFiles, for abandon_all().
std::mutex mutex;
PartFile* first = nullptr;

constexpr const char* kExtension = ".part";

/// How the names of unfinished files of a target begin. The length does not depend on the target's.
std::string part_prefix(const std::filesystem::path& target) {
    // FNV-1a. Targets with equal hashes search each other's files, and keep those with a lock.
    std::uint32_t hash = 2166136261U;
    for (const char c : target.filename().string())
        hash = (hash ^ static_cast<unsigned char>(c)) * 16777619U;
    std::array<char, 16> prefix{};
    std::snprintf(prefix.data(), prefix.size(), ".aula-%08x-", static_cast<unsigned>(hash));
    return prefix.data();
}

/// An unpredictable name of an unfinished file.
std::string random_name(const std::string& prefix) {
    std::random_device random;
    const std::uint64_t bits = std::uint64_t{random()} << 32U | random();
    std::array<char, 20> name{};
    std::snprintf(name.data(), name.size(), "%016llx", static_cast<unsigned long long>(bits));
    return prefix + name.data() + kExtension;
}

void remove_file(const std::filesystem::path& file) {
    std::error_code ignored;
    std::filesystem::remove(file, ignored);
}

/// Opens and locks a new file, unless the name is taken.
std::optional<int> create(const std::filesystem::path& file, bool replaces) {
    const std::optional<int> descriptor = create_file(file, replaces);
    if (!descriptor || lock_name(*descriptor, file) != NameLock::busy) return descriptor;
    // Another process has taken it for the file of an ended one, before it was locked.
    close(*descriptor);
    remove_file(file);
    return std::nullopt;
}

/// Removes the unfinished files that ended processes have left, which are those without a lock.
void remove_left_parts(const std::filesystem::path& folder, const std::string& prefix) {
    std::error_code error;
    std::filesystem::directory_iterator entry(folder, error);
    for (; !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
        const std::string name = entry->path().filename().string();
        if (!name.starts_with(prefix) || !name.ends_with(kExtension)) continue;
        const int descriptor = open_locked(entry->path());
        if (descriptor < 0) continue;
        remove_file(entry->path());
        close(descriptor);
    }
}

}  // namespace

std::filesystem::path file_behind_links(const std::filesystem::path& name) {
    constexpr int kMostLinks = 40;  // of Linux
    // The canonical form of a relative name may be relative, but that of "./" and a name is not.
    std::filesystem::path file = name.empty() ? name : std::filesystem::absolute(name);
    for (int links = 0; links < kMostLinks; ++links) {
        std::error_code error;
        file = std::filesystem::weakly_canonical(file, error);
        std::filesystem::file_status status;
        if (!error) {
            status = std::filesystem::symlink_status(file, error);
            if (status.type() == std::filesystem::file_type::not_found) return file;
        }
        if (!error && !std::filesystem::is_symlink(status)) return file;
        // A link to a file that does not exist.
        if (!error) file = file.parent_path() / std::filesystem::read_symlink(file, error);
        if (error) throw std::system_error(error);
    }
    throw std::system_error(std::make_error_code(std::errc::too_many_symbolic_link_levels));
}

PartFile::PartFile(const std::filesystem::path& file) : target_(file_behind_links(file)) {
    check_replaceable(file);
    const std::string prefix = part_prefix(target_);
    remove_left_parts(target_.parent_path(), prefix);
    std::error_code ignored;
    const bool replaces = std::filesystem::exists(target_, ignored);
    const std::lock_guard lock(mutex);
    std::optional<int> created;
    do {
        temporary_ = target_.parent_path() / random_name(prefix);
        created = create(temporary_, replaces);
    } while (!created);
    descriptor_ = *created;
    try {
        if (replaces) copy_permissions(descriptor_, target_);
    } catch (const std::system_error&) {
        close(descriptor_);
        remove_file(temporary_);
        throw;
    }
    next_ = std::exchange(first, this);
}

PartFile::~PartFile() {
    const std::lock_guard lock(mutex);
    PartFile** link = &first;
    while (*link != this) link = &(*link)->next_;
    *link = next_;
    if (!temporary_.empty()) remove_file(temporary_);
    close(descriptor_);
}

void PartFile::commit() {
    {
        const std::lock_guard lock(mutex);
        complete_ = true;
    }
    // Otherwise a system crash may leave an empty file.
    flush_file(descriptor_);
    {
        const std::lock_guard lock(mutex);
        std::filesystem::rename(temporary_, target_);
        temporary_.clear();
    }
    flush_names(target_.parent_path());
}

void PartFile::abandon_all() {
    mutex.lock();
    for (const PartFile* file = first; file != nullptr; file = file->next_) {
        if (file->complete_) {
            std::error_code ignored;
            std::filesystem::rename(file->temporary_, file->target_, ignored);
        } else {
            remove_file(file->temporary_);
        }
    }
}

}  // namespace aula
