#include "engine/patches/patch_index.h"

#include <catch2/catch.hpp>
#include <map>
#include <random>
#include <set>
#include <vector>

#include "tests/support/statistics.h"

using namespace aula;

TEST_CASE("a patch is found by its key until a move does not use it") {
    PatchIndex index;
    CHECK(index.find(7) == PatchIndex::kNone);
    const std::uint32_t kept = index.use(7);
    index.keep_present();
    const std::uint32_t patch = index.use(8);
    CHECK(index.key(patch) == 8);
    CHECK(index.patch_of(patch) == patch);
    std::vector<std::uint32_t> released;
    const auto note = [&](std::uint32_t gone) {
        CHECK(index.find(8) == gone);
        released.push_back(gone);
    };
    for (int move = 0; move < 3; ++move) {
        index.begin_move();
        CHECK(index.find(8) == patch);
        CHECK(index.use(8) == patch);
        index.release_unused(note);
        CHECK(index.find(8) == patch);
    }
    CHECK(released.empty());
    index.begin_move();
    index.release_unused(note);
    CHECK(released == std::vector<std::uint32_t>{patch});
    CHECK(index.find(8) == PatchIndex::kNone);
    // Patches that exist at keep_present() are never released.
    CHECK(index.find(7) == kept);
}

TEST_CASE("released numbers are reused for patches and for sides") {
    PatchIndex index;
    const std::uint32_t patch = index.use(1);
    const std::uint32_t side = index.add_side(patch);
    CHECK(side != patch);
    CHECK(index.patch_of(side) == patch);
    CHECK(index.size() == 2);
    index.release_side(side);
    const std::uint32_t other = index.use(2);
    CHECK(other == side);
    CHECK(index.patch_of(other) == other);
    CHECK(index.size() == 2);
    index.begin_move();
    index.use(1);
    index.release_unused([](std::uint32_t) {});
    CHECK(index.find(2) == PatchIndex::kNone);
    CHECK(index.add_side(patch) == other);
    CHECK(index.patch_of(other) == patch);
    // Sides are not released for lack of use.
    for (int move = 0; move < 3; ++move) {
        index.begin_move();
        index.use(1);
        index.release_unused([](std::uint32_t) { FAIL("released"); });
    }
}

TEST_CASE("no number is in use twice, and their number is the largest number of rows in use") {
    PatchIndex index;
    std::mt19937_64 random(test::test_seed());
    std::map<std::uint32_t, std::uint64_t> key_of;               // patches
    std::set<std::uint64_t> used;                                // keys in the present move
    std::set<std::uint64_t> all;                                 // keys
    std::vector<std::pair<std::uint32_t, std::uint32_t>> sides;  // row, patch
    std::size_t most = 0;
    for (int move = 0; move < 400; ++move) {
        index.begin_move();
        used.clear();
        std::vector<std::uint32_t> new_patches;
        // Keys of a window that moves on.
        for (int i = 0; i < 20; ++i) {
            const std::uint64_t key = static_cast<std::uint64_t>(move) + random() % 30;
            const std::uint32_t patch = index.use(key);
            used.insert(key);
            const auto [entry, added] = key_of.try_emplace(patch, key);
            REQUIRE(entry->second == key);
            if (added) new_patches.push_back(patch);
        }
        most = std::max(most, key_of.size() + sides.size());
        index.release_unused([&](std::uint32_t patch) {
            REQUIRE(key_of.contains(patch));
            REQUIRE_FALSE(used.contains(key_of.at(patch)));
            // The sides of a patch are released with it.
            std::erase_if(sides, [&](const auto& side) {
                if (side.second != patch) return false;
                index.release_side(side.first);
                return true;
            });
            key_of.erase(patch);
        });
        REQUIRE(key_of.size() == used.size());
        for (const std::uint32_t patch : new_patches) {
            if (key_of.at(patch) % 3 == 0) sides.emplace_back(index.add_side(patch), patch);
        }
        all.insert(used.begin(), used.end());
        for (const auto& [row, patch] : sides) {
            REQUIRE_FALSE(key_of.contains(row));
            REQUIRE(index.patch_of(row) == patch);
        }
        for (const auto& [patch, key] : key_of) REQUIRE(index.find(key) == patch);
        most = std::max(most, key_of.size() + sides.size());
    }
    CHECK(index.size() == most);
    // The companion: many more keys than numbers have passed.
    CHECK(all.size() > 4 * most);
}
