#include "apps/room/waves/wave_join.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <glm/geometric.hpp>
#include <memory>
#include <numbers>
#include <utility>

#include "apps/output/formatted.h"
#include "apps/room/waves/wave_synthesis.h"
#include "audio/dsp/fft.h"
#include "engine/base/near_field.h"
#include "engine/base/worker_pool.h"

namespace aula {

namespace {

using Spectrum = std::vector<std::complex<float>>;

constexpr double kPi = std::numbers::pi;

/// The highest modes are the least exact.
constexpr double kUsedShare = 0.98;

/// Rays are alone where their energy is this multiple of that of modes: a single pair of places
/// differs by less from the mean that rays are.
constexpr double kOutweighed = 4;

/// Of the signals whose energies are sorted into bins, which are multiples of 1 ms.
constexpr double kEnergyRate_hz = 2000;

/// Of amplitudes over the length of a transform, 30 dB. A larger one would raise what filters
/// spread before the beginning, and wraps around to the end, above the decay.
constexpr double kDecay = 31.6;

/// What filters spread over 0.06 s, those of the octave 63 Hz, changes with the decay of a
/// transform by 10 % then.
constexpr double kShortest_s = 2;

/// An octave band with flanks of a quarter octave; the squares of all bands add up to 1.
double octave_mask(std::size_t band, double hz) {
    constexpr double kFlank = 0.25;
    const double centre_hz{kBandCentres_hz[band]};
    return rising_flank(hz, centre_hz / std::numbers::sqrt2, kFlank) *
           falling_flank(hz, centre_hz * std::numbers::sqrt2, kFlank);
}

/// The real part beyond the modes of a direct sound and its derivative, see direct_field_beyond().
/// They change with the wave number as cos(k r): between steps of this phase they are linear.
class DirectBeyond {
 public:
    DirectBeyond(double distance_m, double end, double highest) {
        constexpr double kPhase = 0.25;
        step_ = kPhase / std::max(distance_m, kNearest_m);
        for (double k = 0; k < end + step_; k += step_) {
            // It diverges at the highest mode, which no mask reaches.
            nodes_.push_back(direct_field_beyond(distance_m, std::min(k, end), highest));
        }
    }

    std::array<double, 2> at(double wave_number) const {
        const double position = wave_number / step_;
        const std::size_t i = std::min(static_cast<std::size_t>(position), nodes_.size() - 2);
        const double share = position - static_cast<double>(i);
        return {std::lerp(nodes_[i][0], nodes_[i + 1][0], share),
                std::lerp(nodes_[i][1], nodes_[i + 1][1], share)};
    }

 private:
    double step_;
    std::vector<std::array<double, 2>> nodes_;
};

}  // namespace

WaveTransform::WaveTransform(double length_s, double rate)
    : size(fast_fft_size(
          static_cast<std::size_t>(std::ceil(2 * std::max(length_s, kShortest_s) * rate)) + 2)),
      rate_hz(rate),
      decay_per_s(std::log(kDecay) * rate / static_cast<double>(size)) {}

float WaveTransform::growth(std::size_t sample) const {
    const double whole = sample < size - size / 4 ? 0 : static_cast<double>(size);
    return static_cast<float>(
        std::exp(decay_per_s * (static_cast<double>(sample) - whole) / rate_hz));
}

double path_amplitude(const SoundPath& path, double hz) {
    const double position = std::clamp(std::log2(std::max(hz, 1.0) / double{kBandCentres_hz[0]}),
                                       0.0, static_cast<double>(kBandCount - 1));
    const std::size_t below = std::min(static_cast<std::size_t>(position), kBandCount - 2);
    const auto amplitude = [&](std::size_t band) {
        return std::sqrt(squared_pressure(double{path.energy[band]}));
    };
    return std::lerp(amplitude(below), amplitude(below + 1), position - static_cast<double>(below));
}

WaveSpectra PairWaves::field(const WaveTransform& transform, std::size_t count) const {
    const double step = 2 * kPi * transform.step_hz() / speed_of_sound_m_s_;
    const double shift = transform.decay_per_s / speed_of_sound_m_s_;
    WaveSpectra spectra = response_.modal(step, count, shift);
    const Vec3 along = near_direction(response_.from_source);
    const double distance_m{glm::length(response_.from_source)};
    std::optional<DirectBeyond> beyond;
    if (direct_)
        beyond.emplace(distance_m, step * static_cast<double>(count),
                       response_.highest_wave_number);
    for (std::size_t i = 1; i < count; ++i) {
        const double wave_number = step * static_cast<double>(i);
        std::array<std::complex<double>, 2> direct{};
        if (beyond) {
            const std::array<double, 2> rest = beyond->at(wave_number);
            const auto whole = direct_field(distance_m, {shift, wave_number});
            direct = {rest[0] - whole[0], rest[1] - whole[1]};
        }
        spectra[0][i] += direct[0];
        const std::complex<double> slope(shift, wave_number);
        for (std::size_t a = 0; a < 3; ++a) {
            std::complex<double>& value = spectra[a + 1][i];
            value = (value + direct[1] * double{along[static_cast<int>(a)]}) / slope;
        }
    }
    return spectra;
}

bool PairWaves::is_outweighed(const EnergyResponse& rays) const {
    // The highest octave that modes fill; the lowest one if they fill none.
    std::size_t band = 0;
    while (band + 1 < kBandCount &&
           double{kBandCentres_hz[band + 1]} * std::numbers::sqrt2 < masks_.crossover_hz)
        ++band;
    const WaveTransform transform(rays.bins.length_s(), kEnergyRate_hz);
    const double centre_hz{kBandCentres_hz[band]};
    const auto first =
        static_cast<std::size_t>(centre_hz / std::numbers::sqrt2 / transform.step_hz());
    const auto end = static_cast<std::size_t>(
        std::min(centre_hz * std::numbers::sqrt2, masks_.end_hz()) / transform.step_hz());
    const WaveSpectra field_of_modes = field(transform, end);
    double power = 0;
    for (std::size_t k = first; k < end; ++k) power += std::norm(field_of_modes[0][k]);
    return squared_pressure(rays.total(band)) >
           kOutweighed * power / static_cast<double>(std::max<std::size_t>(1, end - first));
}

WaveEnergy PairWaves::energy(const TimeBins& bins) const {
    const WaveTransform transform(bins.length_s(), kEnergyRate_hz);
    const std::size_t size = transform.size;
    RealFft fft(size);
    const double step_hz = transform.step_hz();
    const auto end = std::min(fft.bins(), static_cast<std::size_t>(masks_.end_hz() / step_hz) + 1);

    WaveSpectra fields = field(transform, end);
    for (std::size_t k = 0; k < end; ++k) {
        const double hz = static_cast<double>(k) * step_hz;
        if (direct_) {
            const std::complex<double> s(transform.decay_per_s, 2 * kPi * hz);
            const double delay_s = double{direct_->length_m} / speed_of_sound_m_s_;
            const std::complex<double> pressure =
                path_amplitude(*direct_, hz) * std::exp(-s * delay_s);
            fields[0][k] += pressure;
            for (int a = 0; a < 3; ++a)
                fields[static_cast<std::size_t>(a) + 1][k] +=
                    double{direct_->direction[a]} * pressure;
        }
        const std::complex<double> mask(masks_.low(hz) *
                                        wave_high_pass({transform.decay_per_s / (2 * kPi), hz}));
        for (auto& spectrum : fields) spectrum[k] *= mask;
    }

    // What filters spread before the arrival belongs to it.
    const double arrival_s = double{glm::length(response_.from_source)} / speed_of_sound_m_s_;
    WaveEnergy result;
    result.energy.resize(bins.count());
    result.directions.resize(bins.count());
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
                filtered[c][k] = std::complex<float>(mask * fields[c][k]);
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
            const float growth = transform.growth(n);
            const float weight = static_cast<float>(scale) * growth * growth;
            const float pressure = signal[0][n];
            result.energy[bin][band] += weight * pressure * pressure;
            // The velocity of a plane wave has its direction.
            DirectionMoments directions =
                DirectionMoments::of({signal[1][n], signal[2][n], signal[3][n]});
            directions.intensity *= pressure;
            result.directions[bin] += directions * weight;
        }
    }
    return result;
}

void WaveEnergy::join(EnergyResponse& response) const {
    for (std::size_t i = 0; i < response.bins.count(); ++i) {
        const float before = response.energy[i].sum();
        response.energy[i] *= rays;
        if (before > 0) response.directions[i] *= response.energy[i].sum() / before;
        response.energy[i] += energy[i];
        response.directions[i] += directions[i];
    }
    for (SoundPath& path : response.paths)
        if (path.kind != SoundPath::Kind::through_walls) path.energy *= rays;
}

WaveJoin::WaveJoin(const Scene& scene, const WaveJoin* before, const std::stop_token& stop)
    : speed_of_sound_m_s_(double{scene.medium.speed_of_sound_m_s()}) {
    const Simulation& simulation = scene.simulation;
    if (!simulation.direct || !simulation.specular || simulation.order != 0) {
        warnings_.emplace_back(
            "waves: not with limits of direct sound, specular paths or the order");
        return;
    }
    find(scene, before, stop);
}

void WaveJoin::find(const Scene& scene, const WaveJoin* before, const std::stop_token& stop) {
    const auto rays = std::make_shared<const RayScene>(scene);
    // Without a given frequency, modes below all octaves are not worth their time.
    const bool is_auto = scene.simulation.waves_hz == Simulation::kHighestWaves_hz;
    const double lowest_hz = is_auto ? double{kBandCentres_hz[0]} / std::numbers::sqrt2
                                     : double{Simulation::kLowestWaves_hz};
    const WaveLimits limits{.highest_hz = std::numbers::sqrt2 * double{scene.simulation.waves_hz},
                            .lowest_hz = std::numbers::sqrt2 / kUsedShare * lowest_hz};
    WorkerPool pool(scene.simulation.threads.value_or(default_threads()));
    for (const Source& source : scene.sources) {
        const std::array<Vec3, 1> place{source.position_at(0)};
        if (stop.stop_requested()) return;
        if (room_at(place[0]) != nullptr) continue;
        auto room = RoomWaves::find(rays, place, speed_of_sound_m_s_, limits, pool,
                                    before != nullptr ? before->room_at(place[0]) : nullptr, stop);
        if (room) {
            rooms_.push_back(std::move(*room));
            continue;
        }
        const RoomFault fault = RoomWaves::fault(rays, place, limits);
        warnings_.push_back(
            "waves: none of source \"" + source.name + "\", because " +
            (fault == RoomFault::open ? "more than 5 % of its room's surface is open"
             : fault == RoomFault::no_air
                 ? "it is in no room"
                 : formatted("the modes that can be computed end below %.0f Hz", lowest_hz)));
    }
}

WaveMasks WaveJoin::masks(const RoomWaves& room) {
    return {kUsedShare * room.highest_hz() / std::numbers::sqrt2};
}

const RoomWaves* WaveJoin::room_at(const Vec3& place) const {
    const auto room = std::find_if(rooms_.begin(), rooms_.end(), [&](const RoomWaves& waves) {
        return waves.grid().cell_at(place).has_value();
    });
    return room == rooms_.end() ? nullptr : &*room;
}

std::optional<PairWaves> WaveJoin::pair(const Vec3& source, const Vec3& receiver,
                                        const EnergyResponse& rays) const {
    const RoomWaves* const room = room_at(source);
    if (room == nullptr) return {};
    const std::optional<WaveResponse> response = room->response(source, receiver);
    if (!response) return {};
    const auto path_of = [&](SoundPath::Kind kind) -> std::optional<SoundPath> {
        const auto path = std::find_if(rays.paths.begin(), rays.paths.end(),
                                       [&](const SoundPath& p) { return p.kind == kind; });
        return path == rays.paths.end() ? std::nullopt : std::optional(*path);
    };
    PairWaves pair(*response, path_of(SoundPath::Kind::direct), masks(*room), speed_of_sound_m_s_);
    // Modes know no transmission.
    if (!pair.direct() && path_of(SoundPath::Kind::through_walls) && pair.is_outweighed(rays))
        return {};
    return pair;
}

}  // namespace aula
