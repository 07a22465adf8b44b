#include "engine/process/files.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <system_error>

#include "aula/exception.h"
#include "engine/process/pages.h"
#include "engine/process/regular_file.h"
#include "tests/support/temporary_folder.h"

namespace files_test {

namespace fs = std::filesystem;

constexpr const char* kName = "K\303\274che.txt";  // Küche, in UTF-8

void write_new(const fs::path& file, const std::string& text) {
    const std::optional<int> descriptor = aula::create_file(file, false);
    REQUIRE(descriptor.has_value());
    aula::write_all(*descriptor, text);
    aula::flush_file(*descriptor);
    aula::close_file(*descriptor);
}

std::string text_of(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

TEST_CASE("a file is created exclusively under a name in UTF-8, and read as it was written") {
    const aula::test::TemporaryFolder folder;
    const fs::path file = folder.path() / aula::utf8_path(kName);
    const std::string text = "one\r\ntwo\n\x1a three";  // no byte is an end or changed
    write_new(file, text);
    CHECK(file.filename().string() == kName);
    CHECK(text_of(file) == text);
    CHECK_FALSE(aula::create_file(file, false).has_value());
    CHECK(aula::read_regular_file(file, 100, "a text") == text);
    CHECK_THROWS_WITH(aula::read_regular_file(folder.path() / "none", 100, "a text"),
                      Catch::EndsWith("none: no such file; expected a text"));
    CHECK_THROWS_WITH(aula::read_regular_file(folder.path(), 100, "a text"),
                      Catch::EndsWith("is a folder, not a regular file; expected a text"));
}

TEST_CASE("an open file is read at any offset up to its end") {
    const aula::test::TemporaryFolder folder;
    write_new(folder.path() / "file", "0123456789");
    const aula::RegularFile file(folder.path() / "file", "a text");
    CHECK(file.size() == 10);
    CHECK(file.read(7, 2) == "78");
    CHECK(file.read(7, 20) == "789");
    CHECK(file.read(20, 1).empty());
    CHECK(aula::regular_size(file.descriptor().number()) == std::uint64_t{10});
}

TEST_CASE("a locked file is not locked twice, and is free when it is closed") {
    const aula::test::TemporaryFolder folder;
    const fs::path file = folder.path() / aula::utf8_path(kName);
    const std::optional<int> first = aula::create_file(file, false);
    REQUIRE(first.has_value());
    REQUIRE(aula::lock_name(*first, file) == aula::NameLock::locked);
    CHECK(aula::open_locked(file) < 0);
    // The owner writes, renames and removes it meanwhile.
    aula::write_all(*first, "text");
    const fs::path renamed = folder.path() / "renamed";
    aula::rename_flushed(file, renamed);
    CHECK(aula::lock_name(*first, file) == aula::NameLock::busy);
    CHECK(aula::open_locked(renamed) < 0);
    close(*first);
    CHECK(text_of(renamed) == "text");
    const int again = aula::open_locked(renamed);
    CHECK(again >= 0);
    close(again);
    CHECK(aula::open_locked(file) < 0);
}

TEST_CASE("a renamed file replaces another one") {
    const aula::test::TemporaryFolder folder;
    write_new(folder.path() / "old", "old");
    write_new(folder.path() / "new", "new");
    aula::rename_flushed(folder.path() / "new", folder.path() / "old");
    CHECK(text_of(folder.path() / "old") == "new");
    CHECK_FALSE(fs::exists(folder.path() / "new"));
    CHECK_THROWS_AS(aula::rename_flushed(folder.path() / "none", folder.path() / "old"),
                    std::system_error);
}

TEST_CASE("a folder is locked by one, and renamed to a free name only") {
    const aula::test::TemporaryFolder folder;
    const fs::path one = folder.path() / "one";
    const fs::path other = folder.path() / "other";
    fs::create_directory(one);
    fs::create_directory(other);
    const std::optional<int> locked = aula::lock_folder(one);
    REQUIRE(locked.has_value());
    CHECK_FALSE(aula::lock_folder(one).has_value());
    // Files are created and removed in it, and it is renamed.
    write_new(one / "file", "text");
    aula::flush_files(one);
    aula::flush_names(one);
    CHECK_FALSE(aula::rename_to_free_name(one, other));
    CHECK(aula::rename_to_free_name(one, folder.path() / "free"));
    CHECK(text_of(folder.path() / "free" / "file") == "text");
    close(*locked);
    const std::optional<int> again = aula::lock_folder(folder.path() / "free");
    CHECK(again.has_value());
    if (again) close(*again);
    CHECK_THROWS_AS(aula::lock_folder(one), std::system_error);
}

TEST_CASE("a file that may not be written is not replaced") {
    const aula::test::TemporaryFolder folder;
    const fs::path file = folder.path() / "file";
    CHECK_NOTHROW(aula::check_replaceable(file));
    write_new(file, "text");
    CHECK_NOTHROW(aula::check_replaceable(file));
    fs::permissions(file, fs::perms::owner_write | fs::perms::group_write | fs::perms::others_write,
                    fs::perm_options::remove);
    CHECK_THROWS_AS(aula::check_replaceable(file), aula::InputError);
    fs::permissions(file, fs::perms::owner_write, fs::perm_options::add);
}

TEST_CASE("a file without a name holds its bytes, and is gone when it is closed") {
    const std::string text(100'000, 'x');
    aula::Descriptor file = aula::anonymous_file(text);
    std::string read(text.size(), '\0');
    CHECK(aula::read_at(file.number(), read.data(), read.size(), 0) == text.size());
    CHECK(read == text);
    CHECK(aula::read_at(file.number(), read.data(), read.size(), text.size()) == 0);
}

TEST_CASE("mapped pages are zero, aligned and writable") {
    constexpr std::size_t kRest = std::size_t{64} << 10;
    for (const std::size_t huge : {std::size_t{0}, aula::kHugePage_bytes}) {
        const std::size_t bytes = huge + kRest;
        auto* const pages = static_cast<unsigned char*>(aula::map_pages(huge, kRest));
        REQUIRE(pages != nullptr);
        CHECK(reinterpret_cast<std::uintptr_t>(pages) % 64 == 0);
        CHECK(pages[0] == 0);
        CHECK(std::memcmp(pages, pages + 1, bytes - 1) == 0);
        std::memset(pages, 1, bytes);
        aula::unmap_pages(pages, bytes);
    }
}

}  // namespace files_test
