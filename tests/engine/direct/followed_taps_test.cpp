#include "engine/direct/followed_taps.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/engine/edges/obstacles.h"

namespace followed_taps_test {

using aula::Bands;
using aula::EdgePath;
using aula::followed_taps;
using aula::kBandCount;
using aula::LevelFollower;
using aula::Object;
using aula::SoundPath;
using aula::TapMemory;
using aula::Vec3;
using aula::test::Place;
using aula::test::prism;

namespace {

const Vec3 kSource(-2, 0, 0);

/// A prism with two edges that sound from the source can pass to the listener.
Place wedge() { return Place({prism({{0, -0.5F}, {0, 0.5F}, {-0.2F, 0}})}); }

/// Place of the listener in the shadow of the prism, after `walked_m` along it.
Vec3 behind(float walked_m) { return {3, 0.1F, walked_m}; }

Bands sum_of(const std::vector<SoundPath>& taps) {
    Bands sum;
    for (const SoundPath& tap : taps) sum += tap.energy;
    return sum;
}

/// A frame: the taps are those of the memory for the next one.
std::vector<SoundPath> frame(const Place& place, const std::vector<EdgePath>& paths,
                             const Bands& model, const Vec3& listener, TapMemory& memory) {
    memory.taps = followed_taps(place.paths, paths, model, kSource, listener, false, memory);
    return memory.taps;
}

void check_equal(const Bands& a, const Bands& b) {
    for (std::size_t i = 0; i < kBandCount; ++i) CHECK(a[i] == Approx(b[i]).epsilon(1e-5));
}

}  // namespace

TEST_CASE("the taps of paths have their energy, by ascending length") {
    const Place place = wedge();
    const auto paths = place.single_paths(kSource, behind(0));
    REQUIRE(paths.size() == 2);
    TapMemory memory;
    const Bands model = place.paths.energy(paths);
    const auto taps = frame(place, paths, model, behind(0), memory);
    REQUIRE(taps.size() == 2);
    CHECK(taps[0].length_m < taps[1].length_m);
    check_equal(sum_of(taps), model);
    // The longer path first: the order of the taps is the same.
    TapMemory other;
    const auto turned = frame(place, {paths[1], paths[0]}, model, behind(0), other);
    REQUIRE(turned.size() == 2);
    CHECK(turned[0].length_m == taps[0].length_m);
    CHECK(turned[1].length_m == taps[1].length_m);
}

TEST_CASE("energies of taps follow a step of their paths") {
    const Place place = wedge();
    TapMemory memory;
    const auto paths = place.single_paths(kSource, behind(0));
    frame(place, paths, place.paths.energy(paths), behind(0), memory);
    const Vec3 beside = behind(0.02F);
    auto louder = place.single_paths(kSource, beside);
    for (EdgePath& path : louder) path.scale(4);
    const Bands model = place.paths.energy(louder);
    const auto taps = frame(place, louder, model, beside, memory);
    const Bands heard = memory.levels.energy();
    check_equal(sum_of(taps), heard);
    for (std::size_t b = 0; b < kBandCount; ++b) {
        // At most half-way in pressure, 2.5 / 4; 2 cm allow at most 1.8 dB.
        CHECK(heard[b] < 0.6F * model[b]);
    }
}

TEST_CASE("where all paths have vanished their taps fade out") {
    const Place place = wedge();
    TapMemory memory;
    const auto paths = place.single_paths(kSource, behind(0));
    const auto first = frame(place, paths, place.paths.energy(paths), behind(0), memory);
    for (int i = 0; i < 4; ++i) {
        const auto taps = frame(place, {}, Bands{}, behind(0), memory);
        REQUIRE(taps.size() == first.size());
        check_equal(sum_of(taps), memory.levels.energy());
        for (std::size_t t = 0; t < taps.size(); ++t) {
            CHECK(taps[t].key == first[t].key);
            // At rest the pressure halves in each frame: the follower's level of silence is below
            // 2e-3 of it.
            for (std::size_t b = 0; b < kBandCount; ++b) {
                const double share = std::pow(0.25, i + 1);
                CHECK(double{taps[t].energy[b]} ==
                      Approx(share * double{first[t].energy[b]}).epsilon(0.1));
            }
        }
    }
    for (int i = 0; i < 20; ++i) frame(place, {}, Bands{}, behind(0), memory);
    CHECK(memory.taps.empty());
}

TEST_CASE("bent sound that vanishes fades out in all octaves beside the sound through a wall") {
    const Place place = wedge();
    TapMemory memory;
    const auto paths = place.single_paths(kSource, behind(0));
    const Bands bent = place.paths.energy(paths);
    frame(place, paths, bent, behind(0), memory);
    // The wall passes nothing in the upper four octaves.
    SoundPath wall;
    wall.kind = SoundPath::Kind::through_walls;
    wall.length_m = 5;
    for (std::size_t b = 0; b < 4; ++b) wall.energy[b] = 1e-3F * bent[b];
    for (int i = 0; i < 3; ++i) {
        memory.taps =
            followed_taps(place.paths, {}, wall.energy, kSource, behind(0), false, memory, wall);
        check_equal(sum_of(memory.taps), memory.levels.energy());
        const auto through = std::find_if(
            memory.taps.begin(), memory.taps.end(),
            [](const SoundPath& tap) { return tap.kind == SoundPath::Kind::through_walls; });
        REQUIRE(through != memory.taps.end());
        check_equal(through->energy, wall.energy);
        // At rest the pressure moves half-way in each frame.
        const double share = std::pow(0.25, i + 1);
        for (std::size_t b = 4; b < kBandCount; ++b)
            CHECK(double{sum_of(memory.taps)[b]} == Approx(share * double{bent[b]}).epsilon(0.1));
    }
    for (int i = 0; i < 20; ++i)
        memory.taps =
            followed_taps(place.paths, {}, wall.energy, kSource, behind(0), false, memory, wall);
    REQUIRE(memory.taps.size() == 1);
    check_equal(memory.taps[0].energy, wall.energy);
}

TEST_CASE("a straight path without edges has no taps when its level is reached") {
    const Place place = wedge();
    const Vec3 listener(-2, 3, 0);
    EdgePath straight;
    straight.length_m = 3;
    for (auto& value : straight.field) value = 1.0 / 3;
    const std::vector<EdgePath> paths{straight};
    const Bands model = place.paths.energy(paths);
    TapMemory memory;
    CHECK(frame(place, paths, model, listener, memory).empty());
    // Small objects between the ends, or a level that is not reached yet, need a tap.
    std::vector<EdgePath> changed = paths;
    changed[0].is_plain = false;
    CHECK(frame(place, changed, model, listener, memory).size() == 1);
    changed[0].scale(2);
    const auto rising = frame(place, changed, place.paths.energy(changed), listener, memory);
    REQUIRE(rising.size() == 1);
    CHECK_FALSE(memory.levels.is_exact());
    check_equal(sum_of(rising), memory.levels.energy());
}

}  // namespace followed_taps_test
