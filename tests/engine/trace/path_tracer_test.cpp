#include "engine/trace/arrival_tracer.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "engine/base/band_vector.h"
#include "engine/base/sampling.h"
#include "engine/trace/detection_spheres.h"
#include "tests/support/rooms.h"
#include "tests/support/statistics.h"

using namespace aula;

namespace {

constexpr float kPi = std::numbers::pi_v<float>;

struct Traced {
    Scene scene;
    RayScene rays;
    PatchSubdivision subdivision;
    TraceSettings settings;
    int specular_order = 0;
    float radius_m = 0.5F;

    explicit Traced(const Scene& room) : scene(room), rays(scene), subdivision(rays, 0.5F) {
        settings.max_length_m = 300;
    }

    std::vector<Arrival> arrivals(std::uint64_t frame_seed) const {
        const SpecularPaths images(rays, specular_order, radius_m, 1);
        const ArrivalTracer tracer(rays, subdivision, images, settings);
        std::vector<Arrival> all;
        for (int b = 0; b < tracer.batch_count(); ++b) {
            ArrivalBatch batch;
            const Receiver receiver{scene.listener.pose.position, radius_m};
            tracer.trace({0, scene.sources[0].position}, {&receiver, 1}, frame_seed, b, batch);
            collect_segment_arrivals(rays, {&receiver, 1}, settings.attenuation_per_m,
                                     settings.rays, batch);
            all.insert(all.end(), batch.arrivals.begin(), batch.arrivals.end());
        }
        return all;
    }
};

double energy_of(const std::vector<Arrival>& arrivals, std::size_t band = 0) {
    double sum = 0;
    for (const Arrival& a : arrivals) sum += double{a.energy[band]};
    return sum;
}

const Scene kBox = test::grey_room(test::box(Vec3(5, 4, 3)), 0.2F, 1, Vec3(1.2F, 1.1F, 1.5F),
                                   Vec3(3.7F, 2.9F, 1.2F));

}  // namespace

TEST_CASE("energies of the orders of a Lambert box are the exact ones") {
    // Exact values at the point for rho = 1, in 1e-2 P/m2, and mean lengths in m.
    const double exact_energy[] = {2.5561, 3.4597, 3.8235, 4.0175, 4.1179, 4.1769};
    const double exact_length_m[] = {5.337, 7.699, 10.103, 12.533, 14.987, 17.465};
    Scene room = kBox;
    room.materials[0].absorption = Bands{};
    Traced traced(room);
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
    Traced a(mixed);
    Traced b(grey);
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
        Traced traced(room);
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
    Traced traced(kBox);
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
    Traced traced(room);
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
        Traced traced(kBox);
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
    Traced traced(room);
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
    Traced dry(kBox);
    Traced damp(kBox);
    damp.settings.attenuation_per_m = Bands::filled(0.01F);
    const auto a = dry.arrivals(3);
    const auto b = damp.arrivals(3);
    REQUIRE(b.size() > 100);
    std::size_t compared = 0;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
        // Without roulette: 0.8^n is far above 1e-8 within 60 m.
        if (a[i].length_m > 60 || a[i].length_m != b[i].length_m) continue;
        // 2e-7 of the polynomial for each of up to 50 reflections.
        CHECK(
            b[i].energy[2] ==
            Approx(double{a[i].energy[2]} * std::exp(-0.01 * double{a[i].length_m})).epsilon(2e-5));
        ++compared;
    }
    CHECK(compared > 50);
}

TEST_CASE("hit points are off the surface on the ray's side, at any distance and angle") {
    // Few triangles, and more than the brute-force intersector takes.
    const std::pair<Object, float> rooms[] = {
        {test::box(Vec3(1000, 150, 40), 0, Vec3(-500, -75, -20)), 19.9F},
        {test::icosphere(100, 4), 99}};
    for (const auto& [walls, from_m] : rooms) {
        const Scene scene = test::grey_room(walls, 0.1F, 1, Vec3(0), Vec3(1));
        const RayScene rays(scene);
        RandomStream random(1);
        const auto paths = std::make_unique<PathBatch>();
        for (int round = 0; round < 50; ++round) {
            paths->count = kLanes;
            for (std::size_t i = 0; i < kLanes; ++i) {
                paths->rays.origin.set(i, from_m * uniform_direction(random.uniform_2d()));
                paths->rays.direction.set(i, uniform_direction(random.uniform_2d()));
                paths->rays.max_m[i] = 1000;
            }
            rays.intersect(paths->rays, paths->count, paths->hits);
            paths->arrive(rays);
            for (std::size_t i = 0; i < kLanes; ++i) {
                REQUIRE(paths->hits.triangle[i] != kNoTriangle);
                const RayScene::Triangle& t = rays.triangle(paths->hits.triangle[i]);
                const glm::dvec3 normal(paths->normal.at(i));
                const double off_m =
                    glm::dot(normal, glm::dvec3(paths->point.at(i)) - glm::dvec3(t.vertices[0]));
                // Single precision rounds positions of a kilometre to 3e-5.
                const float distance_m = paths->hits.distance_m[i];
                CHECK(off_m > 5e-5);
                CHECK(off_m < 2 * double{RayScene::offset_after(distance_m)});
                CHECK(glm::dot(normal, glm::dvec3(paths->rays.direction.at(i))) < 0);
            }
        }
    }
}

TEST_CASE("hit points lie between faces that meet at an acute angle") {
    // Two faces that meet at x = z = 0 with 30 degrees between them, the lower one at z = 0.
    const float slope = std::tan(std::numbers::pi_v<float> / 6);
    Object wedge;
    wedge.vertices = {Vec3(0, -2, 0), Vec3(0, 2, 0),          Vec3(3, -2, 0),
                      Vec3(3, 2, 0),  Vec3(3, -2, 3 * slope), Vec3(3, 2, 3 * slope)};
    wedge.triangles = {{0, 2, 3}, {0, 3, 1}, {0, 4, 5}, {0, 5, 1}};
    wedge.triangle_materials.assign(4, 0);
    const RayScene rays(test::grey_room(wedge, 0.1F, 1, Vec3(2, 0, 0.5F), Vec3(2, 0, 0.6F)));
    RandomStream random(1);
    const auto paths = std::make_unique<PathBatch>();
    int tested = 0;
    for (int round = 0; round < 20; ++round) {
        paths->count = kLanes;
        for (std::size_t i = 0; i < kLanes; ++i) {
            // To the lower face within 0.1 mm of the edge: the point along the normal is on the
            // other side.
            const auto [u, v] = random.uniform_2d();
            const Vec3 origin(1 + u, 0, (0.2F + 0.7F * v) * slope);
            const Vec3 target(2e-5F + 8e-5F * random.uniform(), 2 * random.uniform() - 1, 0);
            paths->rays.origin.set(i, origin);
            paths->rays.direction.set(i, glm::normalize(target - origin));
            paths->rays.max_m[i] = 10;
        }
        rays.intersect(paths->rays, paths->count, paths->hits);
        paths->arrive(rays);
        for (std::size_t i = 0; i < kLanes; ++i) {
            const Vec3 point = paths->point.at(i);
            // Exact, except for rays nearly parallel to the face: their point is offset along the
            // normal.
            if (paths->rays.direction.at(i).z > -0.11F) continue;
            if (paths->hits.triangle[i] > 1) continue;
            CHECK(point.z < slope * point.x);
            CHECK(point.z > 5e-5F);
            ++tested;
        }
    }
    CHECK(tested > 1000);  // companion
}

TEST_CASE("a lobe of negligible energy is never chosen") {
    std::uint64_t state = 0;
    while (RandomStream(state).uniform_2d()[0] != 0) ++state;
    const Scene scene = test::grey_room(test::box(Vec3(5, 4, 3)), 0.1F, 1e-40F, Vec3(1), Vec3(2));
    const auto paths = std::make_unique<PathBatch>();
    paths->count = 1;
    paths->energy[0] = Bands::filled(1);
    paths->random[0] = state;
    paths->scatter(RayScene(scene), Bands{});
    CHECK(paths->to_diffuse[0] == 0);
    CHECK(paths->energy[0].sum() == Approx(0.9 * kBandCount));
}

TEST_CASE("band vectors have reproducible sums, to the bit, and right maxima") {
    RandomStream random(1);
    for (int i = 0; i < 200; ++i) {
        std::array<Bands, 8> whole;
        std::array<BandVector, 8> wholes;
        std::array<BandVector, 8> parts;
        for (std::size_t k = 0; k < 8; ++k) {
            for (float& energy : whole[k].value) energy = random.uniform();
            wholes[k] = load_bands(whole[k]);
            parts[k] = wholes[k] * random.uniform();
        }
        const BandVector sums = sums_over_bands(wholes);
        const BandVector less = sums_over_bands(parts);
        const BandVector maxima = maxima_over_bands(wholes);
        for (std::size_t k = 0; k < 8; ++k) {
            CHECK(sums[k] == whole[k].sum());
            CHECK(maxima[k] == whole[k].max());
            // Rounding cannot make a part larger than the whole.
            CHECK(less[k] <= sums[k]);
        }
    }
}

TEST_CASE(
    "spheres that grow with a segment's energy preserve late specular levels and reduce their "
    "noise") {
    // A box with one pair of hard walls: few rays between them carry its late sound. Exact by
    // images of all orders.
    const Vec3 size(12, 9, 5);
    const Vec3 source = size * Vec3(0.22F, 0.39F, 0.31F);
    const Vec3 listener = size * Vec3(0.71F, 0.62F, 0.27F);
    Scene scene = test::grey_room(test::box(size), 0.4F, 0, source, listener);
    scene.materials.push_back(scene.materials[0]);
    scene.materials[1].absorption = Bands::filled(0.03F);
    Object& walls = scene.objects[0];
    for (std::size_t t = 0; t < walls.triangles.size(); ++t) {
        const auto& [a, b, c] = walls.triangles[t];
        const bool across = walls.vertices[a].x == walls.vertices[b].x &&
                            walls.vertices[a].x == walls.vertices[c].x;
        walls.triangle_materials[t] = across ? 1 : 0;
    }
    constexpr int kBins = 10;
    constexpr float kFirst_m = 34;
    constexpr float kBin_m = 17;
    const auto bin_of = [](double length_m) {
        return static_cast<int>(std::floor((length_m - double{kFirst_m}) / double{kBin_m}));
    };
    std::vector<double> exact(kBins);
    const auto along = [&](int axis, int n) {
        const double length = double{size[axis]};
        const double at = double{source[axis]};
        return (n % 2 == 0 ? n * length + at : (n + 1) * length - at) - double{listener[axis]};
    };
    for (int i = -20; i <= 20; ++i) {
        for (int j = -25; j <= 25; ++j) {
            for (int k = -43; k <= 43; ++k) {
                const double d = std::hypot(along(0, i), along(1, j), along(2, k));
                const int bin = bin_of(d);
                if (bin < 0 || bin >= kBins) continue;
                exact[static_cast<std::size_t>(bin)] +=
                    std::pow(double{1 - 0.03F}, std::abs(i)) *
                    std::pow(double{1 - 0.4F}, std::abs(j) + std::abs(k)) /
                    (4 * double{kPi} * d * d);
            }
        }
    }

    Traced traced(scene);
    traced.settings.rays = 2000;
    traced.settings.max_length_m = kFirst_m + kBins * kBin_m;
    const SpecularPaths images(traced.rays, 0, 0.5F, 1);
    const ArrivalTracer tracer(traced.rays, traced.subdivision, images, traced.settings);
    const Receiver receiver = make_receiver(traced.rays, listener, 0.5F);
    constexpr std::size_t kFrames = 48;
    struct Run {
        std::vector<std::vector<double>> levels{kBins};  ///< [bin][frame] over the exact ones
        double arrivals = 0;
    };
    Run fixed;
    Run grown;
    for (std::size_t f = 0; f < kFrames; ++f) {
        std::vector<ArrivalBatch> batches(static_cast<std::size_t>(tracer.batch_count()));
        for (std::size_t b = 0; b < batches.size(); ++b) {
            tracer.trace({0, source}, {}, derive_seed(test::test_seed(), f), static_cast<int>(b),
                         batches[b]);
        }
        const auto detect = [&](Run& run) {
            for (auto& bin : run.levels) bin.push_back(0);
            for (ArrivalBatch& batch : batches) {
                batch.arrivals.clear();
                collect_segment_arrivals(traced.rays, {&receiver, 1}, Bands{}, traced.settings.rays,
                                         batch);
                run.arrivals += static_cast<double>(batch.arrivals.size());
                for (const Arrival& a : batch.arrivals) {
                    const int bin = bin_of(double{a.length_m});
                    if (bin < 0 || bin >= kBins) continue;
                    run.levels[static_cast<std::size_t>(bin)].back() +=
                        double{a.energy[0]} / traced.settings.rays /
                        exact[static_cast<std::size_t>(bin)];
                }
            }
        };
        detect(fixed);
        size_spheres(std::span(batches));
        detect(grown);
    }
    double fixed_deviation = 0;
    double grown_deviation = 0;
    for (std::size_t k = 0; k < kBins; ++k) {
        const test::Estimate of_fixed = test::estimate(fixed.levels[k]);
        const test::Estimate of_grown = test::estimate(grown.levels[k]);
        const double max = *std::max_element(grown.levels[k].begin(), grown.levels[k].end());
        CAPTURE(k, exact[k], of_fixed.mean, of_fixed.standard_error, of_grown.mean,
                of_grown.standard_error, max);
        // Spheres of up to some metres may move an arrival to a neighbouring bin: 2 %.
        CHECK(std::abs(of_grown.mean - 1) < test::kFamilyZ * of_grown.standard_error + 0.02);
        CHECK(of_grown.standard_error < 0.08);  // so that the check is significant
        fixed_deviation += of_fixed.standard_error * std::sqrt(double{kFrames}) / kBins;
        grown_deviation += of_grown.standard_error * std::sqrt(double{kFrames}) / kBins;
    }
    // The relative standard deviation of a bin and frame. The segments' number and the share of a
    // sphere in the room give 2000 x pi 0.25 x 17 / 540 = 49 equal hits in a bin, of up to four
    // times the mean energy in a fixed sphere or a grown one: at most 2 / sqrt(49) = 0.29 for equal
    // chords, times sqrt(9/8).
    CAPTURE(fixed_deviation, grown_deviation);
    CHECK(grown_deviation < 0.31);
    CHECK(fixed_deviation > 2 * grown_deviation);  // companion
    // Equalisation costs few hits: at most one more for four of mean energy in each band.
    CHECK(grown.arrivals < 1.3 * fixed.arrivals);
}

TEST_CASE("large spheres represent the part of a room that is visible from their centre") {
    // A lossless L-shaped room: fluence is the same everywhere, so that every sphere must find it
    // with any occlusion by walls.
    const Scene scene =
        test::grey_room(test::l_shaped_room(), 0, 0, Vec3(1, 5, 1), Vec3(4.5F, 1.2F, 1.6F));
    const RayScene rays(scene);
    const Receiver receiver = make_receiver(rays, Vec3(4.5F, 1.2F, 1.6F), 0.5F);
    const PatchSubdivision subdivision(rays, 1);
    const SpecularPaths images(rays, 0, 0.5F, 1);
    Traced traced(scene);
    traced.settings.rays = 4000;
    traced.settings.max_length_m = 300;
    const ArrivalTracer tracer(rays, subdivision, images, traced.settings);
    std::vector<std::vector<double>> fluence(17);
    for (int f = 0; f < 8; ++f) {
        for (auto& of_sphere : fluence) of_sphere.push_back(0);
        for (int b = 0; b < tracer.batch_count(); ++b) {
            ArrivalBatch batch;
            tracer.trace({0, Vec3(1, 5, 1)}, {}, derive_seed(test::test_seed(), f), b, batch);
            for (const PathSegment& segment : batch.segments) {
                for (std::size_t k = 0; k < fluence.size(); k += 4) {
                    const auto chord = receiver.chord(rays, segment.origin, segment.direction,
                                                      segment.length_m, k);
                    if (!chord || segment.before_m + chord->at_m < 100) continue;
                    fluence[k].back() += double{chord->share_1_m2} / 4000;
                }
            }
        }
    }
    // c P / V per second, 81 m3, from 100 to 300 m.
    const double exact = 200.0 / 81;
    for (std::size_t k = 0; k < fluence.size(); k += 4) {
        const test::Estimate e = test::estimate(fluence[k]);
        CAPTURE(k, e.mean, e.standard_error, exact);
        // 2 % for 512 probes of the volume.
        CHECK(std::abs(e.mean - exact) < test::kFamilyZ * e.standard_error + 0.02 * exact);
    }
    // Companion: the volume of the whole ball instead of the visible part is far off.
    CHECK(receiver.seen_share[16] < 0.3F);
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
    for (const SpecularPath& path : sound.paths)
        if (path.order == 5) lengths_m[path.id] = path.length_m;
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
    const auto traced = [&](int batch, int rays_of_batch) {
        TraceSettings settings;
        settings.rays = batch * ArrivalTracer::kBatchRays + rays_of_batch;
        ArrivalBatch traced_batch;
        ArrivalTracer(rays, subdivision, images, settings)
            .trace({0, source}, {}, test::test_seed(), batch, traced_batch);
        return traced_batch;
    };
    std::size_t segments_of_few = 0;
    for (int batch = 0; batch < 16; ++batch) {
        const ArrivalBatch few = traced(batch, ArrivalTracer::kBatchRays / 4);
        const ArrivalBatch all = traced(batch, ArrivalTracer::kBatchRays);
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
            if (!found) FAIL("batch " << batch << ", segment " << i << " is another");
        }
    }
    CHECK(segments_of_few > 100);
}

TEST_CASE("roulette preserves the mean of late reflections") {
    // Mirrors that absorb half: from order 27 on a ray has less than -80 dB and roulette begins.
    Scene room = kBox;
    room.materials[0] = {"", Bands::filled(0.5F), Bands{}};
    const RayScene rays(room);
    const PatchSubdivision subdivision(rays, 0.5F);
    const SpecularPaths none(rays, 0, 0.5F, 1);
    TraceSettings settings;
    settings.rays = 40000;
    const auto energy_up_to = [&](int order) {
        settings.order = order;
        const ArrivalTracer tracer(rays, subdivision, none, settings);
        double sum = 0;
        for (int b = 0; b < tracer.batch_count(); ++b) {
            ArrivalBatch batch;
            tracer.trace({0, room.sources[0].position}, {}, test::test_seed(), b, batch);
            for (const SegmentEnergy& sound : batch.segment_energies)
                sum += double{sound.energy[0]};
        }
        return sum / settings.rays;
    };
    const double late = energy_up_to(30) - energy_up_to(29);
    // One ray in 10.7 remains: a standard error of 1.6 %, four of them.
    CHECK(late * std::pow(2.0, 30) == Approx(1).margin(0.063));
}
