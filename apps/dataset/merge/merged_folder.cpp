#include "apps/dataset/merge/merged_folder.h"

#include <array>
#include <cerrno>
#include <fstream>
#include <optional>
#include <system_error>
#include <unordered_set>
#include <utility>

#include "apps/dataset/base/sha256.h"
#include "aula/exception.h"
#include "process/files.h"

namespace aula {

namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& file, const std::error_code& error) {
    throw Failure(file.string() + ": cannot write: " + error.message());
}

[[noreturn]] void fail(const fs::path& file) {
    fail(file, std::error_code(errno, std::generic_category()));
}

/// Throws InputError if the name belongs to anything but a folder whose files its SHA256SUMS lists,
/// or if its owner may not write to one of them.
void check_replaced(const fs::path& folder) {
    std::error_code error;
    const fs::file_status status = fs::symlink_status(folder, error);
    if (status.type() == fs::file_type::not_found) return;
    const std::string expected =
        "; it would be replaced, expected a merged dataset, or nothing (move it away)";
    if (!fs::is_directory(status))
        throw InputError(folder.string(), "", "is not a folder" + expected);
    constexpr std::size_t kName = 66;  // after 64 digits and two spaces
    std::unordered_set<std::string> listed{"SHA256SUMS"};
    std::ifstream sums;
    // Opening a pipe would block.
    if (fs::is_regular_file(folder / "SHA256SUMS", error)) sums.open(folder / "SHA256SUMS");
    for (std::string line; std::getline(sums, line);)
        if (line.size() > kName) listed.insert(line.substr(kName));
    check_replaceable(folder);
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
        const std::string name = entry.path().lexically_relative(folder).string();
        if (!fs::is_directory(entry.symlink_status()) && !listed.contains(name))
            throw InputError(folder.string(), "",
                             "contains \"" + name + "\", which no merge has written" + expected);
        check_replaceable(entry.path());
    }
}

}  // namespace

MergedFolder::MergedFolder(fs::path folder) : folder_(std::move(folder)), out_(folder_) {
    check_replaced(folder_);
}

void MergedFolder::write(const std::string& name, std::string_view content) {
    const fs::path file = path(name);
    fs::create_directories(file.parent_path());
    try {
        const std::optional<int> created = create_file(file, false);
        if (!created) fail(named(name), std::make_error_code(std::errc::file_exists));
        Descriptor descriptor(*created);
        write_all(descriptor.number(), content);
        close_file(descriptor.release());
    } catch (const std::system_error& error) {
        fail(named(name), error.code());
    }
    sums_ += sha256(content) + "  " + name + "\n";
}

void MergedFolder::list(const std::string& name) {
    std::ifstream file(path(name), std::ios::binary);
    Sha256 hash;
    std::array<char, 1 << 16> bytes{};
    do {
        file.read(bytes.data(), bytes.size());
        hash.add({bytes.data(), static_cast<std::size_t>(file.gcount())});
    } while (file);
    if (!file.eof()) fail(named(name));
    sums_ += hash.hex() + "  " + name + "\n";
}

void MergedFolder::commit() {
    write("SHA256SUMS", std::string(sums_));
    check_replaced(folder_);
    out_.commit();
}

}  // namespace aula
