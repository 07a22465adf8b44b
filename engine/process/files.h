#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>
#include <system_error>

#include "process/descriptor.h"

namespace aula {

// What operating systems do with files, beyond the standard library. Descriptors are those of
// <unistd.h>, also on Windows; child processes do not inherit them. Functions throw
// std::system_error, of the category std::generic_category(), unless they say otherwise.

/// The path of a name in UTF-8. On Windows the path of a std::string would be another one, while
/// path::string() is UTF-8 on all systems.
std::filesystem::path utf8_path(std::string_view name);

/// The file of the running program.
std::filesystem::path program_file(std::error_code& error);

/// Open files that the system allows a process.
std::size_t most_open_files();

/// Why no file can be written to a folder, or no error. On Windows only trying tells.
std::error_code folder_refusal(const std::filesystem::path& folder);

/// Opens a file. If it is a pipe, does not wait for another program.
int open_to_read(const std::filesystem::path& file);

/// Opens a device or a pipe to write to.
int open_device(const std::filesystem::path& file);

/// Creates a file exclusively and opens it, unless the name is taken, also by a link. `replaces`:
/// only the user may open it until copy_permissions().
std::optional<int> create_file(const std::filesystem::path& file, bool replaces);

/// A file without a name that holds these bytes.
Descriptor anonymous_file(std::string_view bytes);

/// The size of an open regular file, or nothing if it is not one.
std::optional<std::uint64_t> regular_size(int descriptor);

/// Reads bytes from an offset. Returns their number, 0 at the end of the file.
std::size_t read_at(int descriptor, void* bytes, std::size_t size, std::uint64_t offset);

/// Writes all bytes.
void write_all(int descriptor, std::string_view bytes);

/// Closes a file, which may report a late error.
void close_file(int descriptor);

/// Flushes an open file to the disk, and reports late errors as closing it would. Some file systems
/// do not support it.
void flush_file(int descriptor);

/// Flushes all files of a folder to the disk.
void flush_files(const std::filesystem::path& folder);

/// Flushes the names in a folder to the disk: otherwise a system crash may undo a renaming.
void flush_names(const std::filesystem::path& folder);

/// Gives an open file the permissions of the one that it will replace. On Windows a file has those
/// of its folder.
void copy_permissions(int descriptor, const std::filesystem::path& from);

/// The same for a folder. `usable`: its owner may use it anyway.
void copy_folder_permissions(const std::filesystem::path& folder, const std::filesystem::path& from,
                             bool usable);

/// Throws InputError if `target` exists and its owner may not write to it. Checks the mode, because
/// the superuser may write to all files.
void check_replaceable(const std::filesystem::path& target);

/// Renames a file or a folder, replaces a file of that name, and flushes the folder of `to` to the
/// disk.
void rename_flushed(const std::filesystem::path& from, const std::filesystem::path& to);

/// Renames a folder, unless the name is taken: then returns false.
bool rename_to_free_name(const std::filesystem::path& from, const std::filesystem::path& to);

/// Exchanges the names of two folders. Returns false if they have their old names, because the
/// system cannot do it at once.
bool exchange_names(const std::filesystem::path& one, const std::filesystem::path& other) noexcept;

/// The result of lock_name().
enum class NameLock {
    locked,
    busy,        ///< another open file has the lock, or the name belongs to another file by now
    unsupported  ///< the file system has no locks
};

/// Locks an open file under its name, without waiting, until all duplicates of the descriptor are
/// closed. A process that is killed has no locks any more. Throws nothing.
NameLock lock_name(int descriptor, const std::filesystem::path& name);

/// Opens and locks an existing file, but no link. Returns -1 if it cannot be locked. Throws
/// nothing.
int open_locked(const std::filesystem::path& file);

/// Opens and locks an existing folder, unless another process has locked, renamed or removed it.
std::optional<int> lock_folder(const std::filesystem::path& folder);

}  // namespace aula
