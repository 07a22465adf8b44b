#include "engine/trace/arrival_tracer.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>
#include <set>
#include <vector>

#include "engine/base/sampling.h"
#include "tests/engine/trace/traced_room.h"
#include "tests/support/rooms.h"
#include "tests/support/statistics.h"

using namespace aula;
using test::TracedRoom;

namespace {

constexpr float kPi = std::numbers::pi_v<float>;

double energy_of(const std::vector<Arrival>& arrivals, std::size_t band = 0) {
    double sum = 0;
    for (const Arrival& a : arrivals) sum += double{a.energy[band]};
    return sum;
}

const Scene kBox = test::grey_room(test::box(Vec3(5, 4, 3)), 0.2F, 1, Vec3(1.2F, 1.1F, 1.5F),
                                   Vec3(3.7F, 2.9F, 1.2F));

}  // namespace

TEST_CASE("a batch that is cleared is empty") {
    ArrivalBatch batch;
    batch.segments.resize(1);
    batch.segment_energies.resize(1);
    batch.segment_identifiers.resize(1);
    batch.departures.resize(1);
    batch.arrivals.resize(1);
    batch.segment_count = 1;
    batch.clear();
    CHECK(batch.segments.empty());
    CHECK(batch.segment_energies.empty());
    CHECK(batch.segment_identifiers.empty());
    CHECK(batch.departures.empty());
    CHECK(batch.arrivals.empty());
    CHECK(batch.segment_count == 0);
}

TEST_CASE("energies of the orders of a Lambert box are the exact ones") {
    // Exact values at the point for rho = 1, in 1e-2 P/m2, and mean lengths in m.
    const double exact_energy[] = {2.5561, 3.4597, 3.8235, 4.0175, 4.1179, 4.1769};
    const double exact_length_m[] = {5.337, 7.699, 10.103, 12.533, 14.987, 17.465};
    Scene room = kBox;
    room.materials[0].absorption = Bands{};
    TracedRoom traced(room);
    traced.settings.rays = 65536;
    traced.radius_m = 0.2F;
    constexpr int kFrames = 16;
    // The same rays with one order more: the difference is that order.
    std::vector<std::vector<double>> energy(7);
    std::vector<std::vector<double>> length(7);
    for (int f = 0; f < kFrames; ++f) {
        for (int order = 0; order <= 6; ++order) {
            double sum = 0;
            double moment = 0;
            if (order > 0) {
                traced.settings.order = order;
                for (const Arrival& a : traced.arrivals(derive_seed(test::test_seed(), f))) {
                    sum += double{a.energy[0]} / traced.settings.rays;
                    moment += double{a.energy[0]} * double{a.length_m} / traced.settings.rays;
                }
            }
            energy[static_cast<std::size_t>(order)].push_back(sum);
            length[static_cast<std::size_t>(order)].push_back(moment);
        }
    }
    for (std::size_t order = 1; order <= 6; ++order) {
        std::vector<double> e;
        std::vector<double> l;
        const double exact = exact_energy[order - 1] * 1e-2;
        for (std::size_t f = 0; f < kFrames; ++f) {
            e.push_back(energy[order][f] - energy[order - 1][f]);
            l.push_back((length[order][f] - length[order - 1][f]) / exact);
        }
        const test::Estimate of_energy = test::estimate(e);
        const test::Estimate of_length = test::estimate(l);
        CAPTURE(order, of_energy.mean, of_energy.standard_error, of_length.mean,
                of_length.standard_error);
        // The sphere averages fluence over 0.2 m: below 0.3 % for fields that vary over metres.
        CHECK(std::abs(of_energy.mean - exact) <
              test::kFamilyZ * of_energy.standard_error + 0.003 * exact);
        CHECK(std::abs(of_energy.z(1.12 * exact)) > test::kFamilyZ);  // companion
        CHECK(std::abs(of_length.mean - exact_length_m[order - 1]) <
              test::kFamilyZ * of_length.standard_error + 0.006 * exact_length_m[order - 1]);
    }
}

TEST_CASE("each band keeps its own absorption and scattering on a shared ray") {
    // Bands with the same absorption must agree in total energy for any values of the others, and a
    // band with alpha = 1 must be silent.
    Scene mixed = kBox;
    mixed.materials[0].absorption = {{0.2F, 0.5F, 0.2F, 1.0F, 0.2F, 0.05F, 0.9F, 0.2F}};
    Scene grey = kBox;
    TracedRoom a(mixed);
    TracedRoom b(grey);
    std::vector<double> ratio;
    for (int f = 0; f < 40; ++f) {
        a.settings.rays = b.settings.rays = 4000;
        a.settings.max_length_m = b.settings.max_length_m = 60;
        const auto mixed_arrivals = a.arrivals(derive_seed(test::test_seed(), f));
        const auto grey_arrivals = b.arrivals(derive_seed(test::test_seed(), 1000 + f));
        CHECK(energy_of(mixed_arrivals, 3) == 0);
        ratio.push_back(energy_of(mixed_arrivals, 2) / energy_of(grey_arrivals, 2));
    }
    const test::Estimate e = test::estimate(ratio);
    CAPTURE(e.mean, e.standard_error);
    // A ratio of noisy sums is biased by their relative variance, here below 1e-3.
    CHECK(std::abs(e.mean - 1) < test::kFamilyZ * e.standard_error + 1e-3);
}

TEST_CASE("energy is conserved for any scattering, with roulette") {
    // Lossless room: late fluence per second is c P / V, for any scattering.
    for (const float scattering : {0.0F, 0.1F, 0.5F, 1.0F}) {
        Scene room = kBox;
        room.materials[0].absorption = Bands{};
        room.materials[0].scattering = Bands::filled(scattering);
        room.materials[0].scattering[5] = 0.3F;  // one band differs
        TracedRoom traced(room);
        traced.settings.max_length_m = 120;
        traced.settings.rays = 4000;
        std::vector<double> late;
        std::vector<double> late_other;
        for (int f = 0; f < 24; ++f) {
            double sum = 0;
            double other = 0;
            for (const Arrival& a : traced.arrivals(derive_seed(test::test_seed(), f))) {
                if (a.length_m < 40 || a.length_m > 110) continue;
                sum += double{a.energy[0]} / 4000;
                other += double{a.energy[5]} / 4000;
            }
            late.push_back(sum);
            late_other.push_back(other);
        }
        // Fluence per metre of path is P / V; 70 m of it.
        const double exact = 70.0 / 60;
        for (const auto& samples : {late, late_other}) {
            const test::Estimate e = test::estimate(samples);
            CAPTURE(scattering, e.mean, e.standard_error);
            CHECK(std::abs(e.z(exact)) < test::kFamilyZ);
            CHECK(std::abs(e.z(0.85 * exact)) > test::kRefutedZ);  // companion
        }
    }
}

TEST_CASE("plain path tracing has the variance of independent hits") {
    TracedRoom traced(kBox);
    traced.settings.independent_rays = true;
    traced.settings.rays = 2000;
    // Arrivals between 12 and 15 m, counted and by energy.
    std::vector<double> counts;
    std::vector<double> energies;
    std::vector<double> weights;  // of single arrivals
    traced.settings.max_length_m = 16;
    constexpr int kFrames = 1500;
    for (int f = 0; f < kFrames; ++f) {
        double count = 0;
        double energy = 0;
        for (const Arrival& a : traced.arrivals(derive_seed(test::test_seed(), f))) {
            if (a.length_m < 12 || a.length_m > 15) continue;
            ++count;
            energy += double{a.energy[0]};
            weights.push_back(double{a.energy[0]});
        }
        counts.push_back(count);
        energies.push_back(energy);
    }
    const auto relative_variance = [](const std::vector<double>& x) {
        const test::Estimate e = test::estimate(x);
        return e.standard_error * e.standard_error * static_cast<double>(x.size()) /
               (e.mean * e.mean);
    };
    const double k = test::estimate(counts).mean;
    // A variance from n samples has a relative standard error of about sqrt(2 / n) = 3.7 %.
    CHECK(relative_variance(counts) == Approx(1 / k).epsilon(4 * 0.037));
    // Compound Poisson: E[x^2] / (k E[x]^2); with chords alone that is 9/8, so (9/8)(1 + v^2) for a
    // spread v of the energies. Here E[x^2] / E[x]^2 is taken from the arrivals themselves.
    double first = 0;
    double second = 0;
    for (double w : weights) {
        first += w;
        second += w * w;
    }
    const auto n = static_cast<double>(weights.size());
    const double spread = second / n / ((first / n) * (first / n));
    CHECK(spread > 9.0 / 8 * 0.98);  // 2 % for 10^4 arrivals
    CHECK(relative_variance(energies) == Approx(spread / k).epsilon(4 * 0.037));
    CHECK(relative_variance(energies) > 1.08 / k);  // companion: energies vary more than counts
}

TEST_CASE("chords of a uniform field have the variance factor 9/8") {
    // A lossless room: all energies are 1, only chords differ; a listener in the middle excludes
    // chords clipped at walls.
    Scene room = kBox;
    room.materials[0].absorption = Bands{};
    room.listener.pose.position = Vec3(2.5F, 2, 1.5F);
    TracedRoom traced(room);
    traced.settings.rays = 20000;
    traced.settings.max_length_m = 100;
    double first = 0;
    double second = 0;
    double n = 0;
    for (const Arrival& a : traced.arrivals(test::test_seed())) {
        first += double{a.energy[0]};
        second += double{a.energy[0]} * double{a.energy[0]};
        ++n;
    }
    REQUIRE(n > 20000);
    // Relative standard error of the ratio: about 0.5 / sqrt(n) < 0.4 %.
    CHECK(second / n / (first / n * first / n) == Approx(9.0 / 8).epsilon(0.016));
    // Mean chord 4 R / 3 over the volume 4/3 pi R^3.
    CHECK(first / n == Approx(4.0 / 3 * 0.5 / (4.0 / 3 * double{kPi} * 0.125)).epsilon(0.016));
}

TEST_CASE("the error falls with the square root of the rays") {
    const auto spread = [](int rays) {
        TracedRoom traced(kBox);
        traced.settings.independent_rays = true;
        traced.settings.rays = rays;
        traced.settings.max_length_m = 30;
        std::vector<double> sums;
        for (int f = 0; f < 400; ++f) {
            sums.push_back(energy_of(traced.arrivals(derive_seed(test::test_seed(), rays, f))) /
                           rays);
        }
        return test::estimate(sums).standard_error;
    };
    // Two standard deviations with 3.5 % relative error each: 5 % for the ratio, four of them.
    CHECK(spread(250) / spread(4000) == Approx(4).epsilon(0.2));
}

TEST_CASE("purely specular paths up to the specular order are omitted for the image sources") {
    Scene room = kBox;
    room.materials[0].scattering = Bands{};
    TracedRoom traced(room);
    traced.settings.rays = 20000;
    traced.settings.order = 3;
    traced.specular_order = 3;
    CHECK(traced.arrivals(1).empty());
    traced.specular_order = 2;
    CHECK_FALSE(traced.arrivals(1).empty());
    traced.settings.specular = false;
    CHECK(traced.arrivals(1).empty());
}

TEST_CASE("air attenuates energy by path length") {
    Scene room = kBox;
    room.materials[0].absorption = Bands::filled(0.05F);
    TracedRoom dry(room);
    TracedRoom damp(room);
    damp.settings.attenuation_per_m = Bands::filled(0.01F);
    const auto a = dry.arrivals(3);
    const auto b = damp.arrivals(3);
    REQUIRE(b.size() > 100);
    std::size_t compared = 0;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
        // Without roulette: 0.95^n exp(-0.6) is above 1e-3 within 60 m.
        if (a[i].length_m > 60 || a[i].length_m != b[i].length_m) continue;
        // 2e-7 of the polynomial for each of up to 50 reflections.
        CHECK(
            b[i].energy[2] ==
            Approx(double{a[i].energy[2]} * std::exp(-0.01 * double{a[i].length_m})).epsilon(2e-5));
        ++compared;
    }
    CHECK(compared > 50);
}

TEST_CASE("a specular ray has the key of the path that an image source counts, from either end") {
    // Of order 5 there are too many sequences of six walls to list.
    Scene room = kBox;
    room.materials[0].scattering = Bands{};
    const RayScene rays(room);
    const Vec3 source = room.sources[0].position;
    const Vec3 listener = room.listener.pose.position;
    SpecularPaths images(rays, 5, 0.5F, 1);
    REQUIRE(images.listed_order() == 4);
    SpecularSound sound;
    for (std::uint64_t frame = 0; frame < 100; ++frame) {
        images.discover(listener, frame);
        sound = images.find(source, listener, false, Bands{});
    }
    std::map<std::uint64_t, float> lengths_m;
    for (const SoundPath& path : sound.paths)
        if (path.order == 5) lengths_m[path.key] = path.length_m;
    REQUIRE(lengths_m.size() > 50);

    const PatchSubdivision subdivision(rays, 0.5F);
    TraceSettings settings;
    settings.rays = 40000;
    settings.order = 5;
    const ArrivalTracer tracer(rays, subdivision, images, settings);
    for (const bool from_listener : {false, true}) {
        const Emitter emitter{0, from_listener ? listener : source, from_listener};
        const Vec3 target = from_listener ? source : listener;
        int crossing = 0;
        int known = 0;
        for (int b = 0; b < tracer.batch_count(); ++b) {
            ArrivalBatch batch;
            tracer.trace(emitter, {}, test::test_seed(), b, batch);
            for (std::size_t i = 0; i < batch.segments.size(); ++i) {
                const PathSegment& segment = batch.segments[i];
                const float along = glm::dot(target - segment.origin, segment.direction);
                const float beside =
                    glm::distance(target, segment.origin + along * segment.direction);
                if (along < 0 || along > segment.length_m || beside > 0.15F) continue;
                ++crossing;
                const auto found = lengths_m.find(batch.segment_energies[i].image);
                // A ray 15 cm beside the target is shorter by at most that.
                known += found != lengths_m.end() &&
                         std::abs(found->second - segment.before_m - along) < 0.15F;
            }
        }
        CAPTURE(from_listener, crossing, known);
        CHECK(crossing > 30);
        // A ray beside the target may follow an image that is audible only there.
        CHECK(known > 0.9 * crossing);
    }
}

TEST_CASE("the result of a ray does not depend on the other rays of its batch") {
    // A room of many planes without a ceiling: rays end at any time and others take their lanes.
    Object walls = test::bumpy_box(Vec3(5, 4, 3), 0.5F, 0.005F);
    std::erase_if(walls.triangles, [&](const auto& triangle) {
        return std::all_of(triangle.begin(), triangle.end(),
                           [&](std::uint32_t v) { return walls.vertices[v].z > 2.9F; });
    });
    walls.triangle_materials.assign(walls.triangles.size(), 0);
    const Vec3 source(1.2F, 1.1F, 1.5F);
    const Scene room = test::grey_room(walls, 0.1F, 0.2F, source, source);
    const RayScene rays(room);
    const PatchSubdivision subdivision(rays, 0.5F);
    const SpecularPaths images(rays, 4, 0.5F, 1);
    REQUIRE(images.listed_order() == 1);
    const auto traced = [&](int frame, int ray_count) {
        TraceSettings settings;
        settings.rays = ray_count;
        const ArrivalTracer tracer(rays, subdivision, images, settings);
        REQUIRE(tracer.batch_count() == 1);
        ArrivalBatch batch;
        tracer.trace({0, source}, {}, derive_seed(test::test_seed(), frame), 0, batch);
        return batch;
    };
    std::size_t segments_of_few = 0;
    for (int frame = 0; frame < 24; ++frame) {
        const ArrivalBatch few = traced(frame, 20);
        const ArrivalBatch all = traced(frame, 80);
        segments_of_few += few.segments.size();
        for (std::size_t i = 0; i < few.segments.size(); ++i) {
            bool found = false;
            for (std::size_t k = 0; k < all.segments.size(); ++k) {
                found = found || (all.segments[k].origin == few.segments[i].origin &&
                                  all.segments[k].direction == few.segments[i].direction &&
                                  all.segments[k].before_m == few.segments[i].before_m &&
                                  all.segment_energies[k].energy.value ==
                                      few.segment_energies[i].energy.value &&
                                  all.segment_energies[k].image == few.segment_energies[i].image &&
                                  all.segment_identifiers[k] == few.segment_identifiers[i]);
            }
            if (!found) FAIL("frame " << frame << ", segment " << i << " is another");
        }
    }
    CHECK(segments_of_few > 100);
}

TEST_CASE("the batches of a frame are about equally large") {
    const Scene room = test::grey_room(test::box(Vec3(5, 4, 3)), 0, 1, Vec3(1), Vec3(2));
    const RayScene rays(room);
    const PatchSubdivision subdivision(rays, 0.5F);
    const SpecularPaths none(rays, 0, 0.5F, 1);
    for (const int count : {1, 47, 95, 96, 300, 400, 600, 1000, 1024, 1025, 1'000'000'000}) {
        TraceSettings settings;
        settings.rays = count;
        const ArrivalTracer tracer(rays, subdivision, none, settings);
        CHECK(tracer.rays_of(0) == 0);
        CHECK(tracer.rays_of(tracer.batch_count()) == count);
        // For as many threads, unless a batch would have less than 64 rays.
        CHECK(tracer.batch_count() >= std::min(8, std::max(1, count / 64)));
        std::set<int> sizes;
        for (int b = 0; b < tracer.batch_count(); b += 1 + b / 100) {
            sizes.insert(tracer.rays_of(b + 1) - tracer.rays_of(b));
        }
        CHECK(*sizes.begin() >= std::min(count, 32));
        CHECK(*sizes.rbegin() <= PathTracer::kBatchRays);
        CHECK(*sizes.rbegin() - *sizes.begin() <= 31);
    }
}

TEST_CASE("each segment of a path arrives at a receiver at most once, also as other paths end") {
    // A room without a ceiling, and roulette: the paths of a batch become fewer at any time.
    Object walls = test::box(Vec3(5, 4, 3));
    std::erase_if(walls.triangles, [&](const auto& triangle) {
        return std::all_of(triangle.begin(), triangle.end(),
                           [&](std::uint32_t v) { return walls.vertices[v].z > 2.9F; });
    });
    walls.triangle_materials.assign(walls.triangles.size(), 0);
    TracedRoom traced(
        test::grey_room(walls, 0.2F, 1, Vec3(1.2F, 1.1F, 1.5F), Vec3(3.7F, 2.9F, 1.2F)));
    traced.settings.rays = 20000;
    std::vector<std::array<float, 4>> places;
    for (const Arrival& a : traced.arrivals(test::test_seed())) {
        places.push_back({a.length_m, a.direction.x, a.direction.y, a.direction.z});
    }
    REQUIRE(places.size() > 1000);
    std::sort(places.begin(), places.end());
    CHECK(std::adjacent_find(places.begin(), places.end()) == places.end());
}

TEST_CASE("roulette preserves the mean of late reflections") {
    // Mirrors that absorb half: from order 10 on a ray has less than -30 dB and roulette begins.
    Scene room = kBox;
    room.materials[0] = {"", Bands::filled(0.5F), Bands{}};
    const RayScene rays(room);
    const PatchSubdivision subdivision(rays, 0.5F);
    const SpecularPaths none(rays, 0, 0.5F, 1);
    TraceSettings settings;
    settings.rays = 80000;
    struct Sum {
        double energy = 0;
        double paths = 0;
    };
    const auto up_to = [&](int order) {
        settings.order = order;
        const ArrivalTracer tracer(rays, subdivision, none, settings);
        Sum sum;
        for (int b = 0; b < tracer.batch_count(); ++b) {
            ArrivalBatch batch;
            tracer.trace({0, room.sources[0].position}, {}, test::test_seed(), b, batch);
            for (const SegmentEnergy& sound : batch.segment_energies) {
                sum.energy += double{sound.energy[0]};
                ++sum.paths;
            }
        }
        return sum;
    };
    constexpr int kOrder = 20;
    const Sum all = up_to(kOrder);
    const Sum earlier = up_to(kOrder - 1);
    const double left = std::pow(0.5, kOrder);
    const double energy = (all.energy - earlier.energy) / settings.rays;
    const double share = (all.paths - earlier.paths) / settings.rays;
    // The square root of what is left below -30 dB: one ray in 32, a standard error of 2 %.
    CHECK(energy / left == Approx(1).margin(0.08));
    CHECK(share / std::sqrt(left / 1e-3) == Approx(1).margin(0.08));
}
