#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>

#include "apps/bench/base/statistics.h"
#include "apps/bench/base/table.h"
#include "apps/bench/convolution/block_times.h"
#include "apps/bench/convolution/uniform_convolver.h"
#include "apps/bench/propagation/fluctuation.h"
#include "apps/bench/propagation/reference.h"
#include "aula/engine/scene_file.h"
#include "engine/base/sampling.h"
#include "tests/support/measure.h"
#include "tests/support/rooms.h"

using namespace aula;
using namespace aula::bench;

namespace {

/// The box of 5 x 4 x 3 m with lossless Lambert walls.
Scene lossless_box() {
    Scene scene = load_scene(AULA_SOURCE_DIR "/scenes/reference/box_5x4x3.json").scene;
    for (Material& material : scene.materials) material.absorption = Bands{};
    return scene;
}

Reference::Estimate energy_up_to(int order, const Scene& scene, const Vec3& source,
                                 const Vec3& listener, std::uint64_t rays) {
    Simulation simulation = scene.simulation;
    simulation.order = order;
    // Long enough for the sixth order of the box: its mean length is 17 m, and 0.5 s are 171 m.
    Reference reference(scene, simulation, 0, source, {listener}, 50);
    WorkerPool workers(2);
    reference.trace(rays, workers);
    return reference.energy(0, {0, 50});
}

/// A response of one arrival in one direction at a time.
EnergyResponse arrival_at(double time_s, float energy, const Vec3& direction) {
    EnergyResponse response = EnergyResponse::silent(TimeBins(0.6));
    const std::size_t bin = response.bins.index(time_s);
    response.energy[bin] = Bands::filled(energy / kBandCount);
    response.directions[bin] = DirectionMoments::of(direction) * energy;
    return response;
}

}  // namespace

TEST_CASE("the reference gives the exact energies of a Lambert box, order by order") {
    // Sums over the orders up to n of the exact solution for rho = 1 at (1.2, 1.1, 1.5) and
    // (3.7, 2.9, 1.2); printed to 5 digits.
    const double exact[] = {0.025561, 0.034597, 0.038235, 0.040175, 0.041179, 0.041769};
    const Scene scene = lossless_box();
    const Vec3 source = scene.sources[0].position;
    const Vec3 listener = scene.listener.pose.position;
    double wanted = 0;
    for (int order = 1; order <= 6; ++order) {
        wanted += exact[order - 1] * kBandCount;
        const Reference::Estimate found = energy_up_to(order, scene, source, listener, 1 << 17);
        CAPTURE(order, found.mean, wanted, found.standard_error);
        // Precise enough to detect 1 %; fixed seed; 3.5 standard errors are exceeded by chance in
        // 0.3 % of such families of six; rounding of the solution 2e-5.
        CHECK(found.standard_error < 0.003 * wanted);
        CHECK(std::abs(found.mean - wanted) < 3.5 * found.standard_error + 2e-5 * wanted);
        // Companion: a deviation by 2 % in the last order is detected.
        const double wrong = wanted + 0.02 * wanted;
        CHECK(std::abs(found.mean - wrong) > 3.5 * found.standard_error);
    }
}

TEST_CASE("the reference's standard error is that of independent repetitions") {
    const Scene scene = lossless_box();
    const Vec3 source = scene.sources[0].position;
    const Vec3 listener = scene.listener.pose.position;
    std::vector<double> means;
    double claimed = 0;
    constexpr int kRepetitions = 24;
    WorkerPool workers(2);
    for (int i = 0; i < kRepetitions; ++i) {
        Simulation simulation = scene.simulation;
        simulation.order = 2;
        simulation.seed = static_cast<std::uint64_t>(i) + 1;
        Reference reference(scene, simulation, 0, source, {listener}, 50);
        reference.trace(1, workers);
        const Reference::Estimate found = reference.energy(0, {0, 50});
        means.push_back(found.mean);
        claimed += found.standard_error / kRepetitions;
    }
    double mean = 0;
    for (const double m : means) mean += m / kRepetitions;
    double squares = 0;
    for (const double m : means) squares += (m - mean) * (m - mean);
    const double spread = std::sqrt(squares / (kRepetitions - 1));
    // The standard deviation of 24 samples has a relative deviation of 1 / sqrt(46) = 15 %: three
    // of them.
    CHECK(claimed / spread > 0.55);
    CHECK(claimed / spread < 1.45);
}

TEST_CASE("paths that end in mirrors reach the right one of the reference's receivers") {
    // One lossless wall, wholly specular in a half space: source and two receivers above it.
    // Without image sources (order 0) rays find the image of each receiver at 1 / (4 pi d^2).
    Scene scene = lossless_box();
    for (Material& material : scene.materials) material.scattering = Bands{};
    Simulation simulation = scene.simulation;
    simulation.order = 1;
    simulation.specular_order = 0;
    const Vec3 source(2.5, 2, 1.5);
    const std::vector<Vec3> receivers{{1, 1, 1}, {4, 1.5, 2}};
    Reference reference(scene, simulation, 0, source, receivers, 50);
    WorkerPool workers(2);
    reference.trace(1 << 19, workers);
    const Vec3 size(5, 4, 3);
    for (std::size_t r = 0; r < receivers.size(); ++r) {
        double wanted = 0;
        for (int axis = 0; axis < 3; ++axis) {
            for (const float wall : {0.0F, size[axis]}) {
                Vec3 image = source;
                image[axis] = 2 * wall - source[axis];
                // The mean over a sphere of radius R differs from the point by R^2 / (5 d^2);
                // higher terms are negligible.
                const double d2 = std::pow(double{glm::distance(image, receivers[r])}, 2);
                constexpr double kRadius2 =
                    double{Reference::kDetectionRadius_m} * double{Reference::kDetectionRadius_m};
                wanted += kBandCount * (1 + kRadius2 / (5 * d2)) / (4 * std::numbers::pi * d2);
            }
        }
        const Reference::Estimate found = reference.energy(r, {0, 50});
        CAPTURE(r, found.mean, wanted, found.standard_error);
        // Statistical, fixed seed: 3.5 standard errors. Companion: without one of the six images, a
        // tenth or more is missing.
        CHECK(std::abs(found.mean - wanted) < 3.5 * found.standard_error);
        CHECK(found.standard_error < 0.02 * wanted);
    }
}

TEST_CASE("the reference counts reflections over facets, which have no image sources") {
    // A mirror of radius a = 1 m: 1 / (4 pi (p + q + 2 p q / a)^2) at the distances p and q.
    constexpr double kDistance_m = 1.5;
    const Vec3 direction = glm::normalize(Vec3(0.3F, 0.5F, 0.8F));
    Scene scene =
        test::grey_room(test::icosphere(1, 4), 0, 0, 2.5F * direction, 2.501F * direction);
    scene.simulation.specular_order = 3;
    Reference reference(scene, scene.simulation, 0, 2.5F * direction, {2.501F * direction}, 10);
    WorkerPool workers(2);
    reference.trace(1 << 20, workers);
    const double exact =
        kBandCount /
        (4 * std::numbers::pi * std::pow(2 * kDistance_m + 2 * kDistance_m * kDistance_m, 2));
    const Reference::Estimate found = reference.energy(0, {0, 10});
    CAPTURE(found.mean, exact, found.standard_error);
    // Statistical, fixed seed. The sphere of 0.25 m is not wider than several beams: 10 %.
    CHECK(std::abs(found.mean - exact) < 3.5 * found.standard_error + 0.1 * exact);
    CHECK(found.standard_error < 0.06 * exact);
}

TEST_CASE("the reference does not depend on the number of threads") {
    const Scene scene = lossless_box();
    std::vector<std::vector<double>> responses;
    for (const int threads : {1, 3}) {
        Reference reference(scene, scene.simulation, 0, scene.sources[0].position,
                            {scene.listener.pose.position}, 20);
        WorkerPool workers(threads);
        reference.trace(1, workers);
        reference.trace(1, workers);
        responses.push_back(reference.response(0));
    }
    CHECK(responses[0] == responses[1]);
}

TEST_CASE("relative deviation is the standard deviation over the mean, averaged over bins") {
    // Bin 0: 1, 2, 3: deviation 1, mean 2. Bin 1: no spread. Bin 2: always empty, omitted.
    const std::vector<std::vector<double>> restarts{{1, 4, 0}, {2, 4, 0}, {3, 4, 0}};
    CHECK(relative_deviation(restarts, {0, 3}) == Approx(0.25).epsilon(1e-12));
    CHECK(relative_deviation(restarts, {0, 1}) == Approx(0.5).epsilon(1e-12));
}

TEST_CASE("direction deviation is the rms angle from the mean direction") {
    // Two directions 30 degrees to either side of the x axis: each 30 degrees off, n - 1 = 1: 30
    // sqrt(2). Lengths have no effect if both are equal. Single precision inside.
    const float c = std::cos(std::numbers::pi_v<float> / 6);
    const std::vector<std::vector<Vec3>> restarts{{2.0F * Vec3(c, 0.5F, 0)},
                                                  {2.0F * Vec3(c, -0.5F, 0)}};
    CHECK(direction_deviation_deg(restarts, {0, kGroupBins}) ==
          Approx(30 * std::sqrt(2.0)).epsilon(1e-5));
    CHECK(direction_deviation_deg({{Vec3(1, 0, 0)}, {Vec3(1, 0, 0)}}, {0, kGroupBins}) == 0);
}

TEST_CASE("the energy ratio is the mean over groups of the restarts' mean over the reference") {
    // Two groups: twice the reference and equal to it; the second is far weaker and counts equally.
    std::vector<double> reference(10, 1.0);
    std::vector<double> low(10, 1.0);
    std::vector<double> high(10, 3.0);
    for (std::size_t b = 5; b < 10; ++b) {
        reference[b] = 1e-6;
        low[b] = 0.5e-6;
        high[b] = 1.5e-6;
    }
    CHECK(energy_ratio({low, high}, reference, {0, 10}) == Approx(1.5).epsilon(1e-12));
}

TEST_CASE("tracking compares the responses from the reference's peak to the end") {
    const std::vector<double> reference{1, 5, 4, 2};
    const BinRange bins = bins_from_peak(reference);
    CHECK(bins.first == 1);
    CHECK(bins.end == 4);
    // Errors 20 %, 0, 50 %; the first bin's is not counted.
    CHECK(squared_relative_error(std::vector<double>{9, 6, 4, 1}, reference, bins) ==
          Approx(0.04 + 0.25).epsilon(1e-12));
}

TEST_CASE("pink noise has equal energy in each octave, and windows hold the energy of a tone") {
    constexpr std::size_t kSamples = 96000;
    const std::vector<float> noise = pink_noise(kSamples, 48000);
    const auto total = [](const std::vector<double>& windows) {
        return std::accumulate(windows.begin(), windows.end(), 0.0);
    };
    // Ten octaves from 20 Hz to 24 kHz: an octave has log(2) / log(24000 / 20) of the energy.
    for (const double octave_hz : {125.0, 1000.0, 8000.0}) {
        CAPTURE(octave_hz);
        CHECK(total(octave_energy(noise, octave_hz, 48000)) ==
              Approx(0.01 * kSamples * std::log(2) / std::log(1200)).epsilon(0.01));
    }
    std::vector<float> tone(kSamples);
    for (std::size_t n = kSamples / 2; n < kSamples; ++n)
        tone[n] = static_cast<float>(
            std::sin(2 * std::numbers::pi * 1000 * static_cast<double>(n) / 48000));
    const std::vector<double> windows = octave_energy(tone, 1000, 48000);
    REQUIRE(windows.size() == 40);
    CHECK(windows[10] < 0.1);
    CHECK(windows[30] == Approx(1200).epsilon(0.01));
    CHECK(total(octave_energy(tone, 2000, 48000)) < 10);
}

TEST_CASE("the error of the reference is subtracted in squares, down to zero") {
    CHECK(without_reference_error(0.05, 0.04) == Approx(0.03).epsilon(1e-12));
    CHECK(without_reference_error(0.03, 0.04) == 0);
}

TEST_CASE("the standard error of a mean is that of independent values") {
    const std::vector<double> values{1, 2, 4, 5};
    CHECK(mean(values) == Approx(3));
    CHECK(standard_error(values) == Approx(std::sqrt(10.0 / 3 / 4)));
    CHECK(standard_error(std::vector<double>{2}) == 0);
}

TEST_CASE("a reference ends at its number of rays or its CPU time") {
    Settings settings;
    settings.reference_rays = 1000;
    settings.reference_s = 1e6;
    CHECK_FALSE(ReferenceLimit(settings).reached(999));
    CHECK(ReferenceLimit(settings).reached(1000));
    settings.reference_s = 0;
    CHECK(ReferenceLimit(settings).reached(1));
    settings.reference_s = 0.02;
    const ReferenceLimit limit(settings);
    const double began_s = cpu_time_s();
    while (!limit.reached(1) && cpu_time_s() < began_s + 1) {
    }
    CHECK(cpu_time_s() < began_s + 1);
}

TEST_CASE(
    "reflected sound is measured in bins of 10 ms, with image sources, without direct sound") {
    EnergyResponse response = arrival_at(0.123, 2, Vec3(0, 1, 0));
    response.paths.push_back(
        {.length_m = 34.32F, .direction = Vec3(1, 0, 0), .energy = Bands::filled(1)});
    response.paths.push_back({.kind = SoundPath::Kind::image,
                              .order = 1,
                              .length_m = 70.35F,
                              .direction = Vec3(1, 0, 0),
                              .energy = Bands::filled(1),
                              .key = 5});  // 205 ms
    const std::vector<double> energy = estimated_energy(response);
    REQUIRE(energy.size() == 50);
    double sum = 0;
    for (const double e : energy) sum += e;
    // Sums of eight floats.
    CHECK(energy[12] == Approx(2).epsilon(1e-6));
    CHECK(energy[20] == Approx(8).epsilon(1e-6));
    CHECK(sum == Approx(10).epsilon(1e-6));
    const std::vector<Vec3> direction = estimated_direction(response);
    REQUIRE(direction.size() == 10);
    CHECK(glm::length(direction[2] - Vec3(0, 2, 0)) < 1e-5F);
    CHECK(glm::length(direction[4] - Vec3(8, 0, 0)) < 1e-5F);
}

TEST_CASE("reference and estimators agree before image sources have been discovered") {
    // A hall of small planes: only sequences of order 1 are all candidates.
    Scene scene = test::grey_room(test::bumpy_box(Vec3(12, 9, 5), 1, 0.005F), 0.1F, 0.1F,
                                  Vec3(3, 4, 1.5F), Vec3(9, 5, 1.2F));
    scene.simulation.specular_order = 3;
    scene.simulation.rays = 4000;
    scene.simulation.ir_length_s = 0.12F;
    const Vec3 source = scene.sources[0].position;
    const Vec3 listener = scene.listener.pose.position;
    Reference reference(scene, scene.simulation, 0, source, {listener}, 12);
    WorkerPool workers(2);
    reference.trace(1 << 19, workers);
    const Reference::Estimate wanted = reference.energy(0, {0, 10});
    for (const Estimator estimator : {Estimator::pt, Estimator::patch}) {
        Simulation simulation = scene.simulation;
        simulation.estimator = estimator;
        Propagation propagation(scene, simulation);
        // After few frames and after many.
        for (const int frames : {1, 30}) {
            const test::Estimate e = test::estimate(test::restarts(
                propagation, scene, frames == 1 ? 24 : 8, frames, [](const EnergyResponse& r) {
                    const std::vector<double> energy = estimated_energy(r);
                    return std::accumulate(energy.begin(), energy.begin() + 10, 0.0);
                }));
            CAPTURE(estimator_name(estimator), frames, e.mean / wanted.mean,
                    e.standard_error / wanted.mean, wanted.standard_error / wanted.mean);
            // 3 %: more probable sequences are discovered earlier, and spheres of 0.5 m. Without
            // image sources in both the ratio is 1.47 after the first frame.
            CHECK(std::abs(e.mean - wanted.mean) <
                  test::kFamilyZ * std::hypot(e.standard_error, wanted.standard_error) +
                      0.03 * wanted.mean);
            CHECK(std::hypot(e.standard_error, wanted.standard_error) < 0.025 * wanted.mean);
        }
    }
}

TEST_CASE("rays of the reference count the image sources that its chains miss") {
    // Image sources of 4736 planes, each visible from a small part of the room.
    Scene scene = test::grey_room(test::bumpy_box(Vec3(6, 5, 4), 0.25F, 0.005F), 0.1F, 0.1F,
                                  Vec3(1.5F, 2, 1.5F), Vec3(4.5F, 3.2F, 1.2F));
    const auto early = [&](int specular_order) {
        scene.simulation.specular_order = specular_order;
        Reference reference(scene, scene.simulation, 0, scene.sources[0].position,
                            {scene.listener.pose.position}, 10);
        WorkerPool workers(2);
        reference.trace(1 << 20, workers);
        return reference.energy(0, {0, 8});
    };
    const Reference::Estimate with_images = early(3);
    const Reference::Estimate of_rays = early(0);
    CAPTURE(with_images.mean / of_rays.mean, with_images.standard_error / of_rays.mean,
            of_rays.standard_error / of_rays.mean);
    // 1 %: a point and a sphere of 0.25 m. Without the images that are missed 11 % is missing.
    CHECK(std::abs(with_images.mean - of_rays.mean) <
          4 * std::hypot(with_images.standard_error, of_rays.standard_error) + 0.01 * of_rays.mean);
    CHECK(of_rays.standard_error < 0.01 * of_rays.mean);
}

TEST_CASE("late bins range from 50 to 500 ms or the end of the response") {
    CHECK(late_bins(80).first == 5);
    CHECK(late_bins(80).end == 50);
    CHECK(late_bins(30).end == 30);
    CHECK(late_bins(3).count() == 0);
}

TEST_CASE("audible bins begin with the first group that is above -30 dB") {
    std::vector<double> reference(50, 1);
    CHECK(audible_bins(reference).first == 5);
    CHECK(audible_bins(reference).end == 50);
    // A far source: silence, then an onset that reaches -31 dB in the middle of a group.
    std::fill_n(reference.begin(), 11, 0);
    reference[11] = 0.8e-3;
    CHECK(audible_bins(reference).first == 15);
    reference[10] = reference[11] = 1.2e-3;
    CHECK(audible_bins(reference).first == 10);
    // Silence.
    CHECK(audible_bins(std::vector<double>(50, 0)).first == 5);
    CHECK(audible_bins(std::vector<double>(3, 1)).count() == 0);
}

TEST_CASE("a table is aligned and has the same rows in Markdown and JSON") {
    const std::vector<Row> rows{
        {{{"estimator", "pt"},
          {"rays", std::int64_t{1000}},
          {"noise", 0.12345},
          {"none", Value{}}}},
        {{{"estimator", "patch"}, {"rays", std::int64_t{50}}, {"noise", 2.0}, {"none", Value{}}}}};
    const std::vector<Column> columns{{"estimator", "estimator", 0},
                                      {"rays", "rays", 0},
                                      {"noise", "noise", 2},
                                      {"none", "none", 2}};
    CHECK(format_markdown(columns, rows) ==
          "| estimator | rays | noise | none |\n"
          "|---|---:|---:|---:|\n"
          "| pt | 1000 | 0.12 | - |\n"
          "| patch | 50 | 2.00 | - |\n");
    CHECK(format_table(columns, rows) ==
          "estimator  rays  noise  none\n"
          "pt         1000   0.12     -\n"
          "patch        50   2.00     -\n");
    const nlohmann::json document = nlohmann::json::parse(to_json(rows));
    CHECK(document.at("machine").is_string());
    REQUIRE(document.at("rows").size() == 2);
    CHECK(document["rows"][0]["noise"] == 0.12345);
    CHECK(document["rows"][1]["rays"] == 50);
    CHECK(document["rows"][1]["none"].is_null());
}

TEST_CASE("the uniform convolver gives the sum over all inputs from the first sample on") {
    constexpr std::size_t kBlock = 16;
    constexpr std::size_t kBlocks = 6;
    constexpr std::size_t kTaps = 37;  // more than two partitions, the last one not full
    RandomStream random(1);
    const auto noise = [&](std::size_t count) {
        std::vector<float> samples(count);
        for (float& x : samples) x = 2 * random.uniform() - 1;
        return samples;
    };
    const std::vector<std::vector<float>> inputs{noise(kBlock * kBlocks), noise(kBlock * kBlocks)};
    const std::vector<std::vector<float>> filters{noise(kTaps), noise(kTaps)};
    const std::vector<FftLibrary> libraries = fft_libraries();
    if (libraries.empty()) {
        WARN("skipped: no FFT library but Aula's own");
        return;
    }
    const FftLibrary& library = libraries[GENERATE(0U, 1U) % libraries.size()];
    CAPTURE(library.name);
    UniformConvolver convolver(library, 2, 1, kBlock, kTaps);
    for (std::size_t i = 0; i < 2; ++i) convolver.set_filter(i, 0, filters[i]);
    std::vector<float> output(kBlock * kBlocks);
    for (std::size_t b = 0; b < kBlocks; ++b) {
        const float* in[] = {&inputs[0][b * kBlock], &inputs[1][b * kBlock]};
        float* out[] = {&output[b * kBlock]};
        convolver.process(in, out);
    }
    for (std::size_t n = 0; n < output.size(); ++n) {
        double wanted = 0;
        for (std::size_t i = 0; i < 2; ++i) {
            for (std::size_t k = 0; k < std::min(kTaps, n + 1); ++k) {
                wanted += double{filters[i][k]} * double{inputs[i][n - k]};
            }
        }
        // Rounding: 74 products of at most 1, through transforms of 32: some 1e-6.
        CHECK(std::abs(double{output[n]} - wanted) < 2e-5);
    }
}

TEST_CASE("The worst block is the one that is slow in most rounds, not one that was slow once") {
    BlockTimes times(4);
    times.add({1, 2, 1, 1});
    times.add({1, 2, 20, 1});  // another process interfered
    times.add({3, 6, 3, 3});   // the whole machine was slower
    CHECK(times.mean_us() == 1.25);
    CHECK(times.worst_over_mean() == Approx(2 / 1.25));
}
