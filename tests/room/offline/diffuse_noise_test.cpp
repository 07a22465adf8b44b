#include "apps/room/offline/diffuse_noise.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <glm/geometric.hpp>
#include <numbers>

#include "audio/dsp/fft.h"
#include "aula/measurement.h"
#include "tests/support/test_scenes.h"

namespace diffuse_noise_test {

namespace {

using namespace aula;

constexpr double kRate_hz = 16000;
constexpr double kSpeed_m_s = 343.2;
constexpr std::size_t kSegment = 512;

using Spectrum = std::vector<std::complex<double>>;

/// Spectra of successive windows of a signal, without their levels.
std::vector<Spectrum> windows_of(const std::vector<float>& signal, std::size_t first) {
    RealFft fft(kSegment);
    std::vector<Spectrum> spectra;
    std::vector<float> window(kSegment);
    std::vector<std::complex<float>> spectrum(fft.bins());
    for (std::size_t at = first; at + kSegment <= signal.size(); at += kSegment / 2) {
        double energy = 0;
        for (std::size_t n = 0; n < kSegment; ++n) {
            const double hann = 0.5 - 0.5 * std::cos(2 * std::numbers::pi *
                                                     (static_cast<double>(n) + 0.5) / kSegment);
            window[n] = static_cast<float>(hann) * signal[at + n];
            energy += std::pow(double{window[n]}, 2);
        }
        if (!(energy > 0)) break;
        fft.forward(window.data(), spectrum.data());
        Spectrum& level = spectra.emplace_back(spectrum.begin(), spectrum.end());
        for (auto& x : level) x /= std::sqrt(energy);
    }
    return spectra;
}

/// The real part of the coherence of two signals in the bins [first, end), over all windows.
double coherence(const std::vector<Spectrum>& a, const std::vector<Spectrum>& b, std::size_t first,
                 std::size_t end) {
    double cross = 0;
    double power_a = 0;
    double power_b = 0;
    for (std::size_t w = 0; w < std::min(a.size(), b.size()); ++w) {
        for (std::size_t k = first; k < end; ++k) {
            cross += (a[w][k] * std::conj(b[w][k])).real();
            power_a += std::norm(a[w][k]);
            power_b += std::norm(b[w][k]);
        }
    }
    return cross / std::sqrt(power_a * power_b);
}

double sinc(double x) { return x < 1e-6 ? 1 : std::sin(x) / x; }

/// The mean of sin(kd) / (kd) over the bins.
double expected(double distance_m, std::size_t first, std::size_t end) {
    double sum = 0;
    for (std::size_t k = first; k < end; ++k)
        sum += sinc(2 * std::numbers::pi * static_cast<double>(k) * kRate_hz / kSegment /
                    kSpeed_m_s * distance_m);
    return sum / static_cast<double>(end - first);
}

/// Bands of bins of 31.25 Hz: from 94 to 8000 Hz.
constexpr std::array<std::pair<std::size_t, std::size_t>, 6> kBands{
    {{3, 6}, {6, 12}, {12, 24}, {24, 48}, {48, 96}, {96, 250}}};

}  // namespace

TEST_CASE("noises at several points have the coherence sin(kd) / (kd)") {
    const std::vector<Vec3> points{
        {0, 0, 0}, {0.05F, 0, 0}, {0.05F, 0.12F, 0}, {1, 1, 1}, {0, 0, 0}};
    const DiffuseNoise noise(points, 8 * 16000, kRate_hz, kSpeed_m_s, 1);
    std::vector<std::vector<Spectrum>> spectra;
    for (std::size_t i = 0; i < points.size(); ++i) {
        double power = 0;
        for (const float x : noise.at(i)) power += std::pow(double{x}, 2);
        // Statistical: the power of 128000 independent samples has a deviation of 0.3 %.
        CHECK(power / static_cast<double>(noise.at(i).size()) == Approx(1).epsilon(0.012));
        spectra.push_back(windows_of(noise.at(i), 0));
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            const double distance_m = double{glm::distance(points[i], points[j])};
            for (const auto& [first, end] : kBands) {
                INFO(distance_m << " m, bins " << first << " to " << end);
                // Statistical: 250 independent windows of at least 3 bins, of which the Hann window
                // leaves 2 independent: 1 / sqrt(2 * 500) = 0.032; four of these. The companion
                // case of independent noises, below, is 0.
                CHECK(coherence(spectra[i], spectra[j], first, end) ==
                      Approx(expected(distance_m, first, end)).margin(0.13));
            }
        }
    }
    // Coincident points have the same noise.
    for (std::size_t n = 0; n < 1000; ++n)
        CHECK(noise.at(0)[n] == Approx(noise.at(4)[n]).margin(1e-3));
    // The first noise does not depend on the other points.
    const DiffuseNoise alone({points.data(), 1}, 8 * 16000, kRate_hz, kSpeed_m_s, 1);
    for (std::size_t n = 0; n < 1000; ++n)
        CHECK(noise.at(0)[n] == Approx(alone.at(0)[n]).margin(1e-4));
    // Companion: other distances are detected.
    CHECK(coherence(spectra[0], spectra[1], 48, 96) != Approx(expected(0.1, 48, 96)).margin(0.13));
    CHECK(coherence(spectra[0], spectra[1], 48, 96) != Approx(1).margin(0.13));
}

/// A reverberant room with diffuse reverberation only.
Scene diffuse_room() {
    Scene scene = test::small_room();
    scene.materials[0].absorption = Bands::filled(0.05F);
    scene.materials[0].scattering = Bands::filled(1);
    scene.simulation.ir_length_s = 1.5F;
    scene.simulation.rays = 200;
    scene.simulation.specular = false;
    scene.simulation.direct = false;
    return scene;
}

TEST_CASE("the reverberation of an array of microphones has the coherence sin(kd) / (kd)") {
    Scene scene = diffuse_room();
    const Vec3 at(3.7F, 2.9F, 1.2F);
    const std::array<float, 3> distances_m{0.04F, 0.1F, 0.6F};
    std::vector<Pose> microphones{{.position = at}};
    for (const float d : distances_m) microphones.push_back({.position = at + Vec3(0, -d, 0)});
    constexpr int kSources = 6;
    for (int s = 1; s < kSources; ++s) {
        scene.sources.push_back(scene.sources[0]);
        scene.sources.back().name += std::to_string(s);
    }
    const auto measured =
        measure(scene, scene.sources, microphones, {.frames = 8, .parameters = false});
    const OutputFormat output = GENERATE(OutputFormat::mono, OutputFormat::foa);
    const ImpulseResponses responses(*measured, {.sample_rate_hz = kRate_hz, .output = output});
    // Windows from 0.1 s on, of all sources, whose noises are independent.
    std::vector<std::vector<Spectrum>> spectra(microphones.size());
    std::vector<Spectrum> dipole;
    for (std::size_t s = 0; s < kSources; ++s) {
        for (std::size_t m = 0; m < microphones.size(); ++m) {
            const auto channels = responses.response(s, m);
            for (Spectrum& window : windows_of(channels[0], 1600))
                spectra[m].push_back(std::move(window));
            if (m > 0) continue;
            for (Spectrum& window : windows_of(channels.back(), 1600))
                dipole.push_back(std::move(window));
        }
    }
    // The channels of one receiver are incoherent.
    if (output == OutputFormat::foa)
        CHECK(coherence(spectra[0], dipole, 12, 250) == Approx(0).margin(0.13));
    for (std::size_t m = 1; m < microphones.size(); ++m) {
        const double d{distances_m[m - 1]};
        for (const auto& [first, end] : kBands) {
            INFO(d << " m, bins " << first << " to " << end);
            // Statistical: 6 times 43 independent windows, as above.
            CHECK(coherence(spectra[0], spectra[m], first, end) ==
                  Approx(expected(d, first, end)).margin(0.13));
        }
    }
    // Companion: with the same noise at all receivers the coherence would be 1, as for one receiver
    // after the other.
    const auto alone = measure(scene, scene.sources, std::span(microphones).subspan(3, 1),
                               {.frames = 8, .parameters = false});
    const auto first = measure(scene, scene.sources, std::span(microphones).first(1),
                               {.frames = 8, .parameters = false});
    CHECK(coherence(windows_of(ImpulseResponses(*alone, {.sample_rate_hz = kRate_hz,
                                                         .output = OutputFormat::mono})
                                   .response(0)[0],
                               1600),
                    windows_of(ImpulseResponses(*first, {.sample_rate_hz = kRate_hz,
                                                         .output = OutputFormat::mono})
                                   .response(0)[0],
                               1600),
                    96, 250) > 0.9);
}

TEST_CASE("receivers beyond one set, and ears far apart, hear independent reverberation") {
    const Scene scene = diffuse_room();
    const Vec3 at(3.7F, 2.9F, 1.2F);
    const std::size_t next = DiffuseNoise::kMaxPoints;
    std::vector<Pose> receivers(next + 1, Pose{.position = at});
    receivers[1].position.y -= 1.5F;
    const auto measured =
        measure(scene, scene.sources, receivers, {.frames = 1, .parameters = false});
    const ImpulseResponses mono(*measured,
                                {.sample_rate_hz = kRate_hz, .output = OutputFormat::mono});
    const auto windows = [](const ImpulseResponses& responses, std::size_t receiver) {
        return windows_of(responses.response(0, receiver)[0], 1600);
    };
    const auto first = windows(mono, 0);
    CHECK(coherence(first, windows(mono, next - 1), 12, 250) > 0.9);
    // Statistical: 43 independent windows of 238 bins; far above the deviation of 0.01.
    CHECK(coherence(first, windows(mono, next), 12, 250) == Approx(0).margin(0.1));
    const ImpulseResponses ears(*measured,
                                {.sample_rate_hz = kRate_hz, .output = OutputFormat::binaural});
    const auto left = windows(ears, 0);
    CHECK(coherence(left, windows(ears, next - 1), 12, 250) > 0.9);
    CHECK(coherence(left, windows(ears, 1), 12, 250) == Approx(0).margin(0.1));
}

}  // namespace diffuse_noise_test
