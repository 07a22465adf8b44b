#include "apps/session/waves/wave_join.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <glm/geometric.hpp>
#include <memory>
#include <numbers>
#include <utility>

#include "audio/dsp/fft.h"
#include "engine/base/near_field.h"
#include "engine/base/worker_pool.h"

namespace aula {

namespace {

using Spectrum = std::vector<std::complex<float>>;

constexpr double kPi = std::numbers::pi;

/// The corner of the high-pass filter, below all bands.
constexpr double kLowest_hz = 8;

/// The highest modes are the least exact.
constexpr double kUsedShare = 0.98;

/// Of the signals whose energies are sorted into bins, which are multiples of 1 ms.
constexpr double kEnergyRate_hz = 2000;

/// The amplitude 0..1 of a flank about a frequency, in power the complement of its reverse.
double rising(double hz, double about_hz, double octaves) {
    if (!(hz > 0)) return 0;
    return std::sin(kPi / 2 * std::clamp(0.5 + std::log2(hz / about_hz) / octaves, 0.0, 1.0));
}

double falling(double hz, double about_hz, double octaves) {
    if (!(hz > 0)) return 1;
    return std::cos(kPi / 2 * std::clamp(0.5 + std::log2(hz / about_hz) / octaves, 0.0, 1.0));
}

/// Butterworth's high-pass filter of fourth order: without it the constant pressure of a closed
/// room is 30 dB above the modes at 5 Hz. It is causal because what a linear-phase filter spread
/// before the emission would be lost.
std::complex<double> high_pass(double hz) {
    if (!(hz > 0)) return 0;
    const std::complex<double> s(0, hz / kLowest_hz);
    const auto section = [&](double angle) {
        return s * s / (s * s + 2 * std::cos(angle) * s + 1.0);
    };
    return section(kPi / 8) * section(3 * kPi / 8);
}

/// The spectrum of a signal multiplied by a function of the frequency; the end of the signal does
/// not meet its beginning.
template <typename Factor>
void filter(double sample_rate_hz, const Factor& factor, std::vector<float>& signal) {
    const std::size_t samples = signal.size();
    RealFft fft(fast_fft_size(2 * samples + 2));
    signal.resize(fft.size());
    Spectrum spectrum(fft.bins());
    fft.forward(signal.data(), spectrum.data());
    for (std::size_t k = 0; k < fft.bins(); ++k) {
        const double hz = static_cast<double>(k) * sample_rate_hz / static_cast<double>(fft.size());
        spectrum[k] *= std::complex<float>(factor(hz) / static_cast<double>(fft.size()));
    }
    fft.inverse(spectrum.data(), signal.data());
    signal.resize(samples);
}

/// An octave band with flanks of a quarter octave; the squares of all bands add up to 1.
double octave_mask(std::size_t band, double hz) {
    constexpr double kFlank = 0.25;
    const double centre_hz{kBandCentres_hz[band]};
    return rising(hz, centre_hz / std::numbers::sqrt2, kFlank) *
           falling(hz, centre_hz * std::numbers::sqrt2, kFlank);
}

/// The beginning of a warning.
std::string none_of(const Source& source) {
    return "waves: none of source \"" + source.name + "\", because ";
}

/// Twice the responses' length, so that the end of a decay does not meet its beginning.
std::size_t transform_size(double length_s, double rate_hz) {
    return fast_fft_size(static_cast<std::size_t>(std::ceil(2 * length_s * rate_hz)) + 2);
}

}  // namespace

double WaveMasks::low(double hz) const { return falling(hz, crossover_hz, 1); }

double WaveMasks::high(double hz) const { return rising(hz, crossover_hz, 1); }

double WaveMasks::end_hz() const { return crossover_hz * std::numbers::sqrt2; }

WaveField PairWaves::field(double hz, bool with_direct) const {
    const double wave_number = 2 * kPi * hz / speed_of_sound_m_s_;
    WaveField result =
        has_direct_ ? response_.reverberant(wave_number) : response_.modal(wave_number);
    if (!has_direct_ || !with_direct) return result;
    const double distance_m{glm::length(response_.from_source)};
    const auto direct = direct_field(distance_m, wave_number);
    result[0] += direct[0];
    const Vec3 along = near_direction(response_.from_source);
    for (std::size_t a = 0; a < 3; ++a) {
        result[a + 1] += direct[1] * double{along[static_cast<int>(a)]};
    }
    return result;
}

WaveEnergy PairWaves::energy(const TimeBins& bins) const {
    const std::size_t size = transform_size(bins.length_s(), kEnergyRate_hz);
    RealFft fft(size);
    const double step_hz = kEnergyRate_hz / static_cast<double>(size);
    const auto end = std::min(fft.bins(), static_cast<std::size_t>(masks_.end_hz() / step_hz) + 1);

    // W, and the velocities along x, y and z of a wave with the pressure of W.
    std::array<Spectrum, 4> fields;
    for (Spectrum& spectrum : fields) spectrum.assign(end, 0);
    for (std::size_t k = 1; k < end; ++k) {
        const double hz = static_cast<double>(k) * step_hz;
        const std::complex<double> mask = masks_.low(hz) * high_pass(hz);
        const WaveField at = field(hz, true);
        const std::complex<double> slope(0, 2 * kPi * hz / speed_of_sound_m_s_);
        fields[0][k] = std::complex<float>(mask * at[0]);
        for (std::size_t a = 1; a < 4; ++a) {
            fields[a][k] = std::complex<float>(mask * at[a] / slope);
        }
    }

    // What filters spread before the arrival belongs to it.
    const double arrival_s = double{glm::length(response_.from_source)} / speed_of_sound_m_s_;
    WaveEnergy result;
    result.energy.resize(bins.count());
    result.intensity.resize(bins.count(), Vec3(0));
    for (std::size_t band = 0; band < kBandCount; ++band) {
        double all = 0;
        double high = 0;
        std::array<Spectrum, 4> filtered;
        for (Spectrum& spectrum : filtered) spectrum.assign(fft.bins(), 0);
        for (std::size_t k = 1; k < fft.bins(); ++k) {
            const double hz = static_cast<double>(k) * step_hz;
            const double mask = octave_mask(band, hz);
            all += mask * mask;
            high += mask * mask * masks_.high(hz) * masks_.high(hz);
            if (k >= end) continue;
            for (std::size_t c = 0; c < 4; ++c) {
                filtered[c][k] = static_cast<float>(mask) * fields[c][k];
            }
        }
        if (high >= all) break;
        result.rays[band] = static_cast<float>(high / all);
        std::array<std::vector<float>, 4> signal;
        for (std::size_t c = 0; c < 4; ++c) {
            signal[c].resize(size);
            fft.inverse(filtered[c].data(), signal[c].data());
        }
        // The sum of the squares of a flat response is 1 / (4 pi).
        const double scale = 1 / (4 * kPi * static_cast<double>(size) * 2 * all);
        for (std::size_t n = 0; n < size; ++n) {
            const bool is_before = n >= size - size / 4;
            const double time_s = is_before ? 0 : (static_cast<double>(n) + 0.5) / kEnergyRate_hz;
            const std::size_t bin = bins.index(std::max(time_s, arrival_s));
            if (bin >= bins.count()) continue;
            const auto weight = static_cast<float>(scale) * signal[0][n];
            result.energy[bin][band] += weight * signal[0][n];
            result.intensity[bin] += weight * Vec3(signal[1][n], signal[2][n], signal[3][n]);
        }
    }
    return result;
}

void WaveEnergy::join(EnergyResponse& response) const {
    for (std::size_t i = 0; i < response.bins.count(); ++i) {
        const float before = response.energy[i].sum();
        response.energy[i] *= rays;
        if (before > 0) response.intensity[i] *= response.energy[i].sum() / before;
        response.energy[i] += energy[i];
        response.intensity[i] += intensity[i];
    }
    for (SoundPath& path : response.paths) path.energy *= rays;
}

std::array<std::vector<float>, 4> PairWaves::impulse_response(double sample_rate_hz,
                                                              std::size_t samples) const {
    const std::size_t size =
        transform_size(static_cast<double>(samples) / sample_rate_hz, sample_rate_hz);
    RealFft fft(size);
    const double step_hz = sample_rate_hz / static_cast<double>(size);
    std::array<Spectrum, 4> spectra;
    for (Spectrum& spectrum : spectra) spectrum.assign(fft.bins(), 0);
    constexpr std::array<std::size_t, 4> kChannel{0, 3, 1, 2};  // of pressure, x, y, z
    for (std::size_t k = 1; k < fft.bins(); ++k) {
        const double hz = static_cast<double>(k) * step_hz;
        if (hz > masks_.end_hz()) break;
        const std::complex<double> mask =
            masks_.low(hz) * high_pass(hz) / static_cast<double>(size);
        const WaveField at = field(hz, false);
        const std::complex<double> slope(0, 2 * kPi * hz / speed_of_sound_m_s_);
        for (std::size_t c = 0; c < 4; ++c) {
            spectra[kChannel[c]][k] = std::complex<float>(mask * (c == 0 ? at[0] : at[c] / slope));
        }
    }
    std::array<std::vector<float>, 4> result;
    for (std::size_t c = 0; c < 4; ++c) {
        result[c].resize(size);
        fft.inverse(spectra[c].data(), result[c].data());
        result[c].resize(samples);
    }
    return result;
}

void keep_high(const WaveMasks& masks, double sample_rate_hz, std::vector<float>& signal) {
    filter(
        sample_rate_hz, [&](double hz) { return std::complex<double>(masks.high(hz)); }, signal);
}

void cut_subsonic(double sample_rate_hz, std::vector<float>& signal) {
    filter(sample_rate_hz, high_pass, signal);
}

WaveJoin::WaveJoin(const Scene& scene)
    : speed_of_sound_m_s_(double{scene.medium.speed_of_sound_m_s()}) {
    const Simulation& simulation = scene.simulation;
    if (!simulation.direct || !simulation.specular || simulation.order != 0) {
        warnings_.emplace_back(
            "waves: not with limits of direct sound, specular paths or the order");
        return;
    }
    std::vector<const Source*> sources;
    for (const Source& source : scene.sources) {
        if (source.directivity.is_omnidirectional()) {
            sources.push_back(&source);
        } else {
            warnings_.push_back(none_of(source) + "it has a directivity");
        }
    }
    if (!sources.empty()) find(scene, std::move(sources));
}

void WaveJoin::find(const Scene& scene, std::vector<const Source*> sources) {
    const auto rays = std::make_shared<const RayScene>(scene);
    const WaveLimits limits{.highest_hz = std::numbers::sqrt2 * double{scene.simulation.waves_hz}};
    WorkerPool pool(scene.simulation.threads.value_or(default_threads()));
    const auto try_all = [&] {
        std::vector<Vec3> places;
        places.reserve(sources.size());
        for (const Source* source : sources) places.push_back(source->position_at(0));
        waves_ = RoomWaves::find(rays, places, speed_of_sound_m_s_, limits, pool);
    };
    try_all();
    if (!waves_) {
        // Sources without a closed room must not take the modes from the others.
        const std::size_t removed = std::erase_if(sources, [&](const Source* source) {
            const std::array<Vec3, 1> place{source->position_at(0)};
            const RoomFault fault = RoomWaves::fault(rays, place, limits);
            if (fault == RoomFault::none) return false;
            warnings_.push_back(none_of(*source) +
                                (fault == RoomFault::open
                                     ? "more than 5 % of its room's surface is open"
                                     : "it is in no room"));
            return true;
        });
        if (sources.empty()) return;
        if (removed > 0) try_all();
    }
    if (!waves_ || waves_->highest_hz() < double{Simulation::kLowestWaves_hz}) {
        waves_.reset();
        warnings_.emplace_back(
            "waves: none, because the room is too flat or too large for the grid of its modes");
        return;
    }
    masks_.crossover_hz = kUsedShare * waves_->highest_hz() / std::numbers::sqrt2;
}

std::optional<PairWaves> WaveJoin::pair(const Source& source, const Vec3& receiver,
                                        const EnergyResponse& rays) const {
    if (!waves_ || !source.directivity.is_omnidirectional()) return {};
    const std::optional<WaveResponse> response = waves_->response(source.position_at(0), receiver);
    if (!response) return {};
    const bool has_direct =
        std::any_of(rays.paths.begin(), rays.paths.end(),
                    [](const SoundPath& path) { return path.kind == SoundPath::Kind::direct; });
    return PairWaves(*response, has_direct, masks_, speed_of_sound_m_s_);
}

}  // namespace aula
