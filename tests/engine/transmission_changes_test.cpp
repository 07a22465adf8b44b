// Sound through walls: threads, scenes without transmission, changes of materials, and partitions
// of one face.

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>

#include "aula/engine/propagation.h"
#include "aula/engine/scene_file.h"
#include "tests/engine/rooms_in_row.h"
#include "tests/support/measure.h"

using namespace aula;
using aula::test::add_partition;
using aula::test::partition_at;
using aula::test::quad;
using aula::test::row_of_rooms;

TEST_CASE("sound through walls is the same to the bit with any number of threads") {
    Scene scene = row_of_rooms(2, 0.2F, 0.4F);
    scene.simulation.direct = true;
    add_partition(scene, 5, 8.0F);
    for (const Estimator estimator : test::kAllEstimators) {
        Simulation simulation = test::with(scene, estimator, 0.3F);
        Propagation one(scene, simulation);
        simulation.threads = 3;
        Propagation three(scene, simulation);
        for (int f = 0; f < 3; ++f) {
            one.step(test::static_input(scene));
            three.step(test::static_input(scene));
        }
        CAPTURE(estimator_name(estimator));
        CHECK(test::same_bits(one.response(0), three.response(0)));
    }
}

TEST_CASE("each of several sources is heard through a wall from its own distance") {
    Scene scene = row_of_rooms(2, 0.2F, 0.4F);
    scene.simulation.direct = true;
    scene.simulation.specular = false;
    scene.simulation.diffraction_order = 0;
    add_partition(scene, 5, 8.0F);
    scene.sources.push_back(scene.sources[0]);
    scene.sources[1].position += Vec3(0.4F, -0.3F, 0.2F);
    Propagation propagation(scene, test::with(scene, Estimator::patch, 0.3F));
    propagation.step(test::static_input(scene));
    for (std::size_t s = 0; s < 2; ++s) {
        CAPTURE(s);
        const auto& paths = propagation.response(s).paths;
        REQUIRE(paths.size() == 1);
        CHECK(double{paths[0].length_m} ==
              Approx(glm::distance(scene.sources[s].position, scene.listener.pose.position))
                  .margin(1e-3));
    }
}

TEST_CASE("transmission costs nothing and changes nothing where no surface transmits") {
    Scene opaque = row_of_rooms(2, 0.2F, 0.4F);
    add_partition(opaque, 5, std::nullopt);
    opaque.simulation.direct = true;
    Scene unused = opaque;
    unused.materials.push_back(opaque.materials[0]);
    unused.materials.back().sound_reduction_db = Bands::filled(10);
    Scene transmits = opaque;
    transmits.materials[1].sound_reduction_db = Bands::filled(10);
    for (const Estimator estimator : test::kAllEstimators) {
        CAPTURE(estimator_name(estimator));
        Simulation simulation = test::with(opaque, estimator, 0.3F);
        Propagation a(opaque, simulation);
        Propagation b(unused, simulation);
        Propagation c(transmits, simulation);
        simulation.transmission = false;
        Propagation d(transmits, simulation);
        const FrameInput input{.sources = {opaque.sources[0].position},
                               .listeners = {Vec3(3.4F, 2.2F, 1.6F)}};
        for (int f = 0; f < 3; ++f) {
            for (Propagation* p : {&a, &b, &c, &d}) p->step(input);
        }
        CHECK(test::same_bits(a.response(0), b.response(0)));
        CHECK(test::same_bits(a.response(0), d.response(0)));
        CHECK(a.statistics().segments == b.statistics().segments);
        CHECK(a.statistics().segments == d.statistics().segments);
        // Companion: a partition that transmits.
        CHECK_FALSE(test::same_bits(a.response(0), c.response(0)));
        CHECK(a.statistics().segments < c.statistics().segments);
    }
}

TEST_CASE("the door of the shipped scene muffles while it is shut") {
    Scene scene = load_scene(AULA_SOURCE_DIR "/scenes/door.json").scene;
    scene.simulation.rays = 1;
    scene.simulation.specular = false;
    scene.simulation.diffraction_order = 0;
    scene.simulation.ir_length_s = 0.1F;
    const Vec3 source = scene.sources[0].position_at(0);
    const Vec3 in_door(4.1F, 2.2F, 1.1F);
    const Vec3 listener = source + 2.0F * (in_door - source);
    const auto levels_db = [&](double time_s, SoundPath::Kind kind) {
        Propagation propagation(scene, scene.simulation);
        propagation.step({time_s, {source}, {listener}});
        std::array<double, kBandCount> levels{};
        for (const SoundPath& path : propagation.response(0).paths) {
            if (path.kind != kind) continue;
            for (std::size_t b = 0; b < kBandCount; ++b) {
                levels[b] = 10 * std::log10(double{path.energy[b]});
            }
        }
        return levels;
    };
    const auto open_db = levels_db(1, SoundPath::Kind::direct);
    const auto shut_db = levels_db(5, SoundPath::Kind::through_walls);
    CHECK(levels_db(5, SoundPath::Kind::direct)[0] == 0);  // nothing is in sight
    // A hollow wooden door; the share of its scattering leaves it in all directions. The wall
    // beside it blocks a part of the first Fresnel zone, the same in all bands.
    constexpr std::array kReduction_db{10, 14, 19, 23, 18, 17, 21, 24};
    constexpr std::array kScattering{0.03, 0.04, 0.06, 0.08, 0.12, 0.17, 0.24, 0.34};
    const auto beside_db = [&](std::size_t b) {
        return shut_db[b] - open_db[b] + kReduction_db[b] - 10 * std::log10(1 - kScattering[b]);
    };
    CHECK((beside_db(0) > -2 && beside_db(0) < 0));
    for (std::size_t b = 1; b < kBandCount; ++b) {
        CAPTURE(b);
        CHECK(beside_db(b) == Approx(beside_db(0)).margin(0.01));
    }
}

TEST_CASE("a material that begins to transmit is heard, and not after it has become opaque again") {
    Scene scene = row_of_rooms(2, 0.2F, 0.5F);
    add_partition(scene, 5, std::nullopt);
    scene.simulation.direct = true;
    for (const bool whole_object : {false, true}) {
        Propagation propagation(scene, test::with(scene, Estimator::patch, 0.3F, 0.1F));
        const FrameInput input = test::static_input(scene);
        const auto heard = [&] {
            for (int f = 0; f < 4; ++f) propagation.step(input);
            return propagation.response(0).total(2) > 0;
        };
        Material thin = scene.materials[1];
        thin.sound_reduction_db = Bands::filled(12);
        const auto set = [&](const Material& material) {
            if (whole_object) {
                propagation.set_object_material(1, material);
            } else {
                propagation.change_material(1, material);
            }
        };
        CAPTURE(whole_object);
        CHECK_FALSE(heard());
        set(thin);
        CHECK(heard());
        set(scene.materials[1]);
        CHECK_FALSE(heard());
    }
}

TEST_CASE("a wall that begins to transmit opens a room in which nothing was before") {
    Scene scene = row_of_rooms(2, 0.2F, 1);
    add_partition(scene, 5, std::nullopt);
    Scene thin = scene;
    thin.materials[1].sound_reduction_db = Bands::filled(10);
    // At construction source and listener are in the first room.
    scene.listener.pose.position = thin.listener.pose.position = Vec3(3.4F, 2.2F, 1.6F);
    const Simulation simulation = test::with(scene, Estimator::patch, 0.3F);
    const FrameInput behind{.sources = {scene.sources[0].position},
                            .listeners = {Vec3(7.3F, 2.9F, 1.2F)}};
    for (const bool whole_object : {false, true}) {
        Propagation changed(scene, simulation);
        Propagation from_start(thin, simulation);
        for (Propagation* p : {&changed, &from_start}) {
            if (whole_object) {
                p->set_object_material(1, thin.materials[1]);
            } else {
                p->change_material(1, thin.materials[1]);
            }
            p->step(behind);
        }
        CAPTURE(whole_object);
        CHECK(from_start.response(0).total(4) > 0);
        CHECK(test::same_bits(changed.response(0), from_start.response(0)));
    }
}

TEST_CASE("any single triangle that begins to transmit opens a room, also the first of the scene") {
    Scene scene = row_of_rooms(2, 0.2F, 1);
    add_partition(scene, 5, std::nullopt);
    std::rotate(scene.objects.begin(), scene.objects.end() - 1, scene.objects.end());
    const auto own = static_cast<std::uint32_t>(scene.materials.size());
    scene.materials.push_back(scene.materials[1]);
    scene.materials.back().name = "own";
    scene.listener.pose.position = Vec3(3.4F, 2.2F, 1.6F);
    const FrameInput behind{.sources = {scene.sources[0].position},
                            .listeners = {Vec3(7.3F, 2.9F, 1.2F)}};
    for (const std::size_t triangle : {0U, 1U}) {
        Scene one = scene;
        one.objects[0].triangle_materials[triangle] = own;
        Material thin = scene.materials[own];
        thin.sound_reduction_db = Bands::filled(10);
        Propagation propagation(one, test::with(one, Estimator::patch, 0.3F));
        propagation.change_material(own, thin);
        propagation.step(behind);
        CAPTURE(triangle);
        CHECK(propagation.response(0).total(4) > 0);
    }
}

TEST_CASE("nothing passes an opaque partition of one face, oblique or smaller than four patches") {
    // Larger than the room's section, so that no ray passes at its rim.
    const Object oblique = quad(
        {{3.9F, -0.2F, -0.1F}, {6.1F, 4.2F, -0.1F}, {6.1F, 4.2F, 3.1F}, {3.9F, -0.2F, 3.1F}}, 1);
    for (const auto& [partition, patch_size_m] :
         {std::pair(oblique, 0.5F), {partition_at(5, 1), 1.9F}}) {
        CAPTURE(patch_size_m);
        Scene scene = row_of_rooms(2, 0.2F, 0.5F);
        add_partition(scene, 5, std::nullopt);
        scene.objects.back() = partition;
        scene.simulation.patch_size_m = patch_size_m;
        const FrameInput behind = test::static_input(scene);
        FrameInput before = behind;
        before.listeners = {Vec3(3.1F, 2.4F, 1.4F)};
        Propagation propagation(scene, test::with(scene, Estimator::patch, 0.3F));
        const auto level = [&](const FrameInput& input) {
            double sum = 0;
            for (int f = 0; f < 3; ++f) {
                propagation.step(input);
                sum += test::total(propagation.response(0), 4);
            }
            return sum;
        };
        CHECK(level(behind) == 0);
        CHECK(level(before) > 0);
    }
}

TEST_CASE("nothing passes an opaque wall that is in contact with one that transmits") {
    for (const float gap_m : {1e-4F, -1e-4F, 5e-4F, -5e-4F, 1e-3F, -1e-3F, 2e-3F, -2e-3F}) {
        for (const Estimator estimator :
             {Estimator::patch, Estimator::pt, Estimator::dpc, Estimator::dpc_published}) {
            CAPTURE(gap_m, estimator);
            Scene scene = row_of_rooms(2, 0.2F, 0.5F);
            add_partition(scene, 5, 5);
            add_partition(scene, 5 + gap_m, std::nullopt);
            for (const bool swapped : {false, true}) {
                if (swapped) std::swap(scene.sources[0].position, scene.listener.pose.position);
                Propagation propagation(scene, test::with(scene, estimator, 0.3F, 0.5F));
                for (int f = 0; f < 3; ++f) propagation.step(test::static_input(scene));
                CHECK(test::total(propagation.response(0)) == 0);
            }
        }
    }
}

TEST_CASE("an oblique partition of one face transmits as much as by path tracing") {
    Scene scene = row_of_rooms(2, 0.3F, 0.4F);
    add_partition(scene, 5, 25.0F);
    scene.objects.back() = quad(
        {{3.9F, -0.2F, -0.1F}, {6.1F, 4.2F, -0.1F}, {6.1F, 4.2F, 3.1F}, {3.9F, -0.2F, 3.1F}}, 1);
    const auto level = [&](Estimator estimator) {
        Simulation simulation = test::with(scene, estimator, 0.4F);
        simulation.rays = 4000;
        Propagation propagation(scene, simulation);
        return test::estimate(test::restarts(
            propagation, scene, 16, 2, [](const EnergyResponse& r) { return test::total(r); }));
    };
    const test::Estimate patch = level(Estimator::patch);
    const test::Estimate pt = level(Estimator::pt);
    const double error = std::hypot(patch.standard_error, pt.standard_error);
    CAPTURE(patch.mean, patch.standard_error, pt.mean, pt.standard_error);
    // 1 %: the sphere of 0.5 m averages over its volume.
    CHECK(std::abs(pt.mean - patch.mean) < test::kFamilyZ * error + 0.01 * pt.mean);
    // Companion: 1 dB of sound reduction.
    CHECK(std::abs(1.259 * pt.mean - patch.mean) > test::kRefutedZ * error + 0.01 * pt.mean);
}
