#pragma once

#include <filesystem>

namespace aula {

/// The result of lock_name().
enum class NameLock {
    locked,
    busy,        ///< another open file has the lock, or the name belongs to another file by now
    unsupported  ///< the file system has no locks
};

/// Locks an open file or folder under its name, without waiting, until all duplicates of the
/// descriptor are closed. A process that is killed has no locks any more.
NameLock lock_name(int descriptor, const std::filesystem::path& name);

/// Throws InputError if `target` exists and its owner may not write to it. Checks the mode, because
/// the superuser may write to all files.
void check_replaceable(const std::filesystem::path& target);

/// Renames a file or a folder, replaces a file of that name, and flushes the folder of `to` to the
/// disk. Throws std::system_error.
void rename_flushed(const std::filesystem::path& from, const std::filesystem::path& to);

/// Flushes the names in a folder to the disk: otherwise a system crash may undo a renaming. Throws
/// std::system_error.
void flush_names(const std::filesystem::path& folder);

}  // namespace aula
