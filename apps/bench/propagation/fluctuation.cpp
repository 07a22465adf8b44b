#include "apps/bench/propagation/fluctuation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>
#include <random>
#include <string>

#include "audio/dsp/fft.h"
#include "aula/auralizer.h"
#include "aula/exception.h"

namespace aula::bench {

namespace {

constexpr double kRate_hz = 48000;
constexpr double kLowest_hz = 20;
constexpr double kRms = 0.1;
constexpr int kBlock = 512;

/// Octaves of which a window contains several independent samples.
constexpr std::array kOctaves_hz{125, 250, 500, 1000, 2000, 4000, 8000};

double walk_s(const Scene& scene) {
    double walk_s = 0;
    if (scene.listener.path) walk_s = scene.listener.path->duration_s();
    if (const auto& path = scene.sources[0].path) walk_s = std::max(walk_s, path->duration_s());
    return walk_s;
}

/// What the listener hears of a signal, omnidirectional.
std::vector<float> listen(Scene scene, int rays, const std::vector<float>& signal) {
    scene.simulation.rays = rays;
    AuralizerOptions options;
    options.clock = RenderClock::exact;
    options.sample_rate_hz = kRate_hz;
    options.output = OutputFormat::mono;
    options.before_frame = follow_paths(scene);
    Auralizer auralizer(scene, options);
    auralizer.commit(static_cast<std::int64_t>(signal.size()));
    std::vector<float> heard(signal.size());
    for (std::size_t at = 0; at < signal.size();) {
        const auto count = std::min<std::size_t>(kBlock, signal.size() - at);
        const SourceSignal input{auralizer.sources()[0], signal.data() + at};
        float* const output = heard.data() + at;
        auralizer.render({&input, 1}, {&output, 1}, static_cast<int>(count));
        at += count;
    }
    return heard;
}

}  // namespace

std::vector<float> pink_noise(std::size_t samples, double rate_hz) {
    RealFft fft(samples);
    std::vector<std::complex<float>> spectrum(fft.bins());
    std::mt19937 random(1);  // the same values on every machine
    for (std::size_t k = 0; k + 1 < spectrum.size(); ++k) {
        const double frequency_hz = static_cast<double>(k) * rate_hz / static_cast<double>(samples);
        const double phase = 2 * std::numbers::pi * static_cast<double>(random()) / 4294967296.0;
        if (frequency_hz >= kLowest_hz)
            spectrum[k] = std::polar(1 / std::sqrt(frequency_hz), phase);
    }
    std::vector<float> noise(samples);
    fft.inverse(spectrum.data(), noise.data());
    const double energy = std::inner_product(noise.begin(), noise.end(), noise.begin(), 0.0);
    const double gain = kRms / std::sqrt(energy / static_cast<double>(samples));
    for (float& x : noise) x *= static_cast<float>(gain);
    return noise;
}

std::vector<double> octave_energy(const std::vector<float>& signal, double centre_hz,
                                  double rate_hz) {
    RealFft fft(signal.size());
    std::vector<std::complex<float>> spectrum(fft.bins());
    fft.forward(signal.data(), spectrum.data());
    const double bin_hz = rate_hz / static_cast<double>(signal.size());
    for (std::size_t k = 0; k < spectrum.size(); ++k) {
        const double octaves = std::log2(static_cast<double>(k) * bin_hz / centre_hz);
        // The inverse transform has no factor.
        spectrum[k] *= std::abs(octaves) <= 0.5 ? 1.0F / static_cast<float>(signal.size()) : 0.0F;
    }
    std::vector<float> octave(signal.size());
    fft.inverse(spectrum.data(), octave.data());
    const auto window = static_cast<std::size_t>(std::lround(kWindow_s * rate_hz));
    std::vector<double> energy;
    for (std::size_t at = 0; at + window <= octave.size(); at += window) {
        const auto first = octave.begin() + static_cast<std::ptrdiff_t>(at);
        energy.push_back(
            std::inner_product(first, first + static_cast<std::ptrdiff_t>(window), first, 0.0));
    }
    return energy;
}

std::vector<Row> measure_fluctuation(const Subject& subject, const Settings& settings) {
    const Scene& scene = subject.scene;
    const double duration_s = std::min(walk_s(scene), settings.longest_walk_s);
    if (duration_s == 0) {
        throw InputError(subject.name, "/listener",
                         "has no path; expected a listener or source with a path");
    }
    // The first tau is not counted: the estimate has not the number of frames that it averages.
    const double first_s = double{scene.simulation.response_time_s};
    const auto samples =
        fast_fft_size(static_cast<std::size_t>(std::ceil((first_s + duration_s) * kRate_hz)));
    const std::vector<float> noise = pink_noise(samples, kRate_hz);
    const int rays = scene.simulation.ray_count();
    const int converged_rays = std::min(kConvergedRays * rays, Simulation::kMaxRays);
    settings.progress("fluctuation: " + std::to_string(rays) + " rays");
    const std::vector<float> heard = listen(scene, rays, noise);
    settings.progress("fluctuation: " + std::to_string(converged_rays) + " rays");
    const std::vector<float> converged = listen(scene, converged_rays, noise);

    const auto first = static_cast<std::size_t>(std::ceil(first_s / kWindow_s));
    std::vector<Row> rows;
    for (const int octave_hz : kOctaves_hz) {
        const std::vector<double> energy = octave_energy(heard, octave_hz, kRate_hz);
        const std::vector<double> wanted = octave_energy(converged, octave_hz, kRate_hz);
        double squares = 0;
        double largest_db = 0;
        int windows = 0;
        for (std::size_t w = first; w < energy.size(); ++w) {
            if (!(wanted[w] > 0 && energy[w] > 0)) continue;
            const double difference_db = 10 * std::log10(energy[w] / wanted[w]);
            squares += difference_db * difference_db;
            largest_db = std::max(largest_db, std::abs(difference_db));
            ++windows;
        }
        Row row;
        row.figures = {{"bench", "fluctuation"},
                       {"scene", subject.name},
                       {"octave_hz", std::int64_t{octave_hz}},
                       {"rays", std::int64_t{rays}},
                       {"converged_rays", std::int64_t{converged_rays}},
                       {"windows", std::int64_t{windows}},
                       {"fluctuation_db", std::sqrt(squares / std::max(windows, 1))},
                       {"largest_db", largest_db}};
        rows.push_back(row);
    }
    return rows;
}

const std::vector<Column>& fluctuation_columns() {
    static const std::vector<Column> columns =
        columns_of({"octave_hz", "rays", "windows", "fluctuation_db", "largest_db"});
    return columns;
}

}  // namespace aula::bench
