#include "engine/impulse_response.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "engine/multiversion.h"
#include "engine/octave_bank.h"
#include "engine/sampling.h"

namespace aula {
namespace {

constexpr double kCell_s = 0.0005;  // edges and centres of all TimeBins are multiples of it
constexpr double kWarmUp_s = 0.5;   // until the lowest octave's filters ring steadily
constexpr double kLevelling = 8;    // window in samples that are independent in the band
constexpr float kSteps = 32767;     // of a carrier's peak
constexpr std::size_t kChunk_samples = 1024;  // of all channels: they stay in the cache

// Uniform white noise of unit variance, the same bits on every machine.
double noise(RandomStream& random) {
    return (static_cast<double>(random.bits() >> 11) * 0x1p-53 - 0.5) * std::sqrt(12.0);
}

// Scales a carrier so that its power over a sliding window is even: a decay then keeps its slope
// (the standard deviation of T30 at 1 kHz falls from 2.5% to 0.7%), while the window is long enough
// to leave the noise its spectrum.
void level(std::vector<float>& carrier, double power, double window_samples) {
    const auto half =
        static_cast<std::size_t>(std::min(window_samples / 2, static_cast<double>(carrier.size())));
    std::vector<double> energy(carrier.size() + 1);  // of the samples before
    for (std::size_t n = 0; n < carrier.size(); ++n) {
        energy[n + 1] = energy[n] + double{carrier[n]} * double{carrier[n]};
    }
    for (std::size_t n = 0; n < carrier.size(); ++n) {
        const std::size_t begin = n - std::min(n, half);
        const std::size_t end = std::min(n + half + 1, carrier.size());
        const double mean = (energy[end] - energy[begin]) / static_cast<double>(end - begin);
        if (mean > 0) carrier[n] *= static_cast<float>(std::sqrt(power / mean));
    }
}

// A carrier in whole steps, whose size goes to `step`.
std::vector<std::int16_t> in_steps(const std::vector<float>& carrier, float& step) {
    float peak = 0;
    for (const float sample : carrier) peak = std::max(peak, std::abs(sample));
    step = peak / kSteps;
    std::vector<std::int16_t> whole(carrier.size());
    for (std::size_t n = 0; n < carrier.size() && step > 0; ++n) {
        whole[n] = static_cast<std::int16_t>(std::lround(carrier[n] / step));
    }
    return whole;
}

/// A linear function of time, one for each band.
struct Ramp {
    Bands level;  ///< at its start
    Bands slope;  ///< per sample
};

/// A point of the envelope, which is linear in between.
struct Knot {
    std::size_t cell;  ///< starts here
    Bands amplitude;   ///< pressure over a carrier of unit variance
    Vec3 direction;    ///< energy-weighted mean
};

// out[j] = sum over the bands of (level + slope (j + offset)) carrier[j].
AULA_MULTIVERSION void shape(std::size_t count, float offset, const Ramp& line,
                             const std::array<const std::int16_t*, kBandCount>& carrier,
                             float* out) {
    const std::array<const std::int16_t*, kBandCount> c = carrier;
    for (std::size_t j = 0; j < count; ++j) {
        const float t = static_cast<float>(static_cast<int>(j)) + offset;
        float sum = 0;
        for (std::size_t b = 0; b < kBandCount; ++b) {
            sum += (line.level[b] + line.slope[b] * t) * static_cast<float>(c[b][j]);
        }
        out[j] = sum;
    }
}

// out += sum over the rows of (level + slope t) in, the same for a row of a triangle.
AULA_MULTIVERSION void mix(std::size_t count, float offset, std::size_t width, const float* level,
                           const float* slope, const std::array<const float*, 16>& in, float* out) {
    for (std::size_t j = 0; j < count; ++j) out[j] = 0;
    for (std::size_t c = 0; c < width; ++c) {
        const float* const x = in[c];
        const float base = level[c];
        const float rise = slope[c];
        for (std::size_t j = 0; j < count; ++j) {
            const float t = static_cast<float>(static_cast<int>(j)) + offset;
            out[j] += (base + rise * t) * x[j];
        }
    }
}

// A band cannot change faster than about a period of its centre: cut sharper, its carrier would
// spill into the other octaves. So a bin's energy is spread over its own time and a period after
// (1 ms at 1 kHz, 16 ms at 63 Hz: less than the octave's own filter takes).
std::vector<Bands> spread_in_time(const EnergyResponse& energy) {
    const TimeBins& bins = energy.bins;
    std::vector<Bands> out(bins.count());
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const double period_s = 1 / double{kBandCentres_hz[b]};
        for (std::size_t i = 0; i < bins.count(); ++i) {
            const double begin_s = bins.begin_s(i);
            const double end_s = bins.end_s(i) + period_s;
            for (std::size_t k = i; k < bins.count() && bins.begin_s(k) < end_s; ++k) {
                const double overlap_s = std::min(end_s, bins.end_s(k)) - bins.begin_s(k);
                out[k][b] +=
                    energy.energy[i][b] * static_cast<float>(overlap_s / (end_s - begin_s));
            }
        }
    }
    return out;
}

}  // namespace

/// A piece of the envelope between two cells' starts.
struct ImpulseResponseBuilder::Segment {
    std::size_t begin_cell, end_cell;
    Ramp amplitude;      ///< pressure over a carrier of unit variance
    Vec3 direction;      ///< energy-weighted mean at the start
    Vec3 direction_end;  ///< at the end
};

ImpulseResponseBuilder::ImpulseResponseBuilder(double sample_rate_hz, double length_s,
                                               std::uint64_t seed, int ambisonic_order)
    : sample_rate_hz_(sample_rate_hz),
      length_samples_(static_cast<std::size_t>(std::ceil(length_s * sample_rate_hz - 1e-6))),
      field_(ambisonic_order),
      channels_(field_.channels()) {
    assert(sample_rate_hz >= 8000 && length_s > 0);
    const auto warm_up = static_cast<std::size_t>(kWarmUp_s * sample_rate_hz);
    OctaveBank impulse_bank(sample_rate_hz);
    std::array<double, kBandCount> power{};
    for (std::size_t n = 0; n < 2 * warm_up; ++n) {
        const auto h = impulse_bank.process(n == 0 ? 1 : 0);
        for (std::size_t b = 0; b < kBandCount; ++b) power[b] += h[b] * h[b];
    }
    for (std::size_t b = 0; b < kBandCount; ++b) band_power_[b] = static_cast<float>(power[b]);

    const std::size_t cells = static_cast<std::size_t>(
        std::ceil(static_cast<double>(length_samples_) / start_samples(1)));
    for (std::size_t c = 0; c < channels_.size(); ++c) {
        Channel& channel = channels_[c];
        channel.moments.resize(cells);
        std::array<std::vector<float>, kBandCount> carriers;
        for (auto& carrier : carriers) carrier.resize(length_samples_);
        OctaveBank bank(sample_rate_hz);
        RandomStream random(derive_seed(seed, c));
        for (std::size_t n = 0; n < warm_up + length_samples_; ++n) {
            const auto bands = bank.process(noise(random));
            if (n < warm_up) continue;
            for (std::size_t b = 0; b < kBandCount; ++b) {
                carriers[b][n - warm_up] = static_cast<float>(bands[b]);
            }
        }
        for (std::size_t b = 0; b < kBandCount; ++b) {
            // The band is power[b] of half the sample rate wide.
            level(carriers[b], power[b], 2 * kLevelling / power[b]);
            channel.carriers[b] = in_steps(carriers[b], channel.step[b]);
        }
        for (std::size_t cell = 0; cell < cells; ++cell) {
            const std::size_t begin = first_sample(cell);
            const std::size_t end = std::min(first_sample(cell + 1), length_samples_);
            Moments& m = channel.moments[cell];
            for (std::size_t n = begin; n < end; ++n) {
                const float t = middle(n, cell);
                for (std::size_t b = 0; b < kBandCount; ++b) {
                    const float sample =
                        channel.step[b] * static_cast<float>(channel.carriers[b][n]);
                    const float power_b = sample * sample;
                    m.zeroth[b] += power_b;
                    m.first[b] += power_b * t;
                    m.second[b] += power_b * t * t;
                }
            }
        }
    }
}

/// Where a cell starts, in samples.
double ImpulseResponseBuilder::start_samples(std::size_t cell) const {
    return static_cast<double>(cell) * kCell_s * sample_rate_hz_;
}

/// The first sample of a cell; a start that is whole but for rounding is that sample.
std::size_t ImpulseResponseBuilder::first_sample(std::size_t cell) const {
    return static_cast<std::size_t>(std::ceil(start_samples(cell) - 1e-6));
}

/// The middle of a sample from the start of a cell, in samples.
float ImpulseResponseBuilder::middle(std::size_t sample, std::size_t cell) const {
    return static_cast<float>(static_cast<double>(sample) + 0.5 - start_samples(cell));
}

// The amplitude is linear between the edges and the centre of each bin and meets its neighbour's
// at the edge, so that no steps are heard. With a^2 the bin's mean power, e0 and e1 the amplitudes
// at its edges and c the one at its centre, the bin keeps its energy if
//     [(e0^2 + e0 c + c^2) + (c^2 + c e1 + e1^2)] / 6 = a^2, that is
//     c = (sqrt(s^2 + 8 (6 a^2 - q)) - s) / 4,   s = e0 + e1, q = e0^2 + e1^2.
// At the edges stands the geometric mean of both bins' amplitudes (an exponential decay's own
// value), but at most sqrt(3) times the lower one: then q <= 6 a^2 and c is real.
std::vector<ImpulseResponseBuilder::Segment> ImpulseResponseBuilder::envelope(
    const EnergyResponse& energy) const {
    const TimeBins& bins = energy.bins;
    const auto cell_at = [](double time_s) {
        return static_cast<std::size_t>(std::lround(time_s / kCell_s));
    };
    const std::vector<Bands> spread_energy = spread_in_time(energy);
    // Edge, centre, edge, centre .. edge; before and after the response there is silence.
    std::vector<Knot> knots;
    knots.reserve(2 * bins.count() + 1);
    Bands before;
    Vec3 direction_before{0};
    float energy_before = 0;
    for (std::size_t i = 0; i <= bins.count(); ++i) {
        const bool inside = i < bins.count();
        Bands a;
        const Vec3 direction = inside ? energy.direction[i] : Vec3{0};
        const float sum = inside ? energy.energy[i].sum() : 0;
        if (inside) {
            // p^2 = 4 pi I, spread over the bin's samples.
            const double samples = (bins.end_s(i) - bins.begin_s(i)) * sample_rate_hz_;
            const auto k = static_cast<float>(4 * std::numbers::pi / samples);
            for (std::size_t b = 0; b < kBandCount; ++b) a[b] = std::sqrt(k * spread_energy[i][b]);
        }
        Knot edge{cell_at(inside ? bins.begin_s(i) : bins.length_s()), {}, Vec3{0}};
        for (std::size_t b = 0; b < kBandCount; ++b) {
            edge.amplitude[b] =
                std::min(std::sqrt(before[b] * a[b]), std::sqrt(3.0F) * std::min(before[b], a[b]));
        }
        if (sum + energy_before > 0) {
            edge.direction = (direction_before + direction) / (energy_before + sum);
        } else if (i > 0) {
            edge.direction = knots.back().direction;  // what lingers comes from where it came from
        }
        if (i > 0) {
            const Bands& start = knots[knots.size() - 2].amplitude;
            for (std::size_t b = 0; b < kBandCount; ++b) {
                const float s = start[b] + edge.amplitude[b];
                const float q = start[b] * start[b] + edge.amplitude[b] * edge.amplitude[b];
                const float rest = std::max(6 * before[b] * before[b] - q, 0.0F);
                knots.back().amplitude[b] = (std::sqrt(s * s + 8 * rest) - s) / 4;
            }
        }
        knots.push_back(edge);
        if (!inside) break;
        const double centre_s = 0.5 * (bins.begin_s(i) + bins.end_s(i));
        knots.push_back({cell_at(centre_s), {}, sum > 0 ? direction / sum : edge.direction});
        before = a;
        direction_before = direction;
        energy_before = sum;
    }

    std::vector<Segment> segments;
    segments.reserve(knots.size());
    for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
        const Knot& from = knots[k];
        const Knot& to = knots[k + 1];
        const auto per_sample =
            static_cast<float>(1 / (start_samples(to.cell) - start_samples(from.cell)));
        segments.push_back({from.cell,
                            to.cell,
                            {from.amplitude, (to.amplitude + from.amplitude * -1) * per_sample},
                            from.direction,
                            to.direction});
    }
    return segments;
}

/// The sum of squares that each band of a channel is to have.
Bands ImpulseResponseBuilder::wanted_energy(const EnergyResponse& energy) const {
    const double length_s = static_cast<double>(length_samples_) / sample_rate_hz_;
    std::array<double, kBandCount> sum{};
    for (std::size_t i = 0; i < energy.bins.count(); ++i) {
        const double begin_s = energy.bins.begin_s(i);
        const double width_s = energy.bins.end_s(i) - begin_s;
        const double inside = std::clamp((length_s - begin_s) / width_s, 0.0, 1.0);
        for (std::size_t b = 0; b < kBandCount; ++b) sum[b] += inside * double{energy.energy[i][b]};
    }
    Bands wanted;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        wanted[b] = static_cast<float>(double{band_power_[b]} * 4 * std::numbers::pi * sum[b]);
    }
    return wanted;
}

/// What to multiply each band of a channel by so that its squares sum to `wanted`.
Bands ImpulseResponseBuilder::gains(const Channel& channel, const std::vector<Segment>& segments,
                                    const Bands& wanted) const {
    std::array<double, kBandCount> sum{};
    for (const Segment& s : segments) {
        const std::size_t end = std::min(s.end_cell, channel.moments.size());
        Bands energy;
        for (std::size_t cell = s.begin_cell; cell < end; ++cell) {
            // The sum of (level + slope t)^2 c^2 over the cell.
            const auto t = static_cast<float>(start_samples(cell) - start_samples(s.begin_cell));
            const Bands& slope = s.amplitude.slope;
            const Bands level = s.amplitude.level + slope * t;
            const Moments& m = channel.moments[cell];
            energy += level * level * m.zeroth + level * slope * m.first * 2.0F +
                      slope * slope * m.second;
        }
        for (std::size_t b = 0; b < kBandCount; ++b) sum[b] += double{energy[b]};
    }
    Bands gain;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        if (sum[b] > 0) gain[b] = static_cast<float>(std::sqrt(double{wanted[b]} / sum[b]));
    }
    return gain;
}

// Every channel is first shaped with the energies of W; then the field's covariance mixes them,
// moving in a straight line from knot to knot.
void ImpulseResponseBuilder::build(const EnergyResponse& energy, ImpulseResponse& out) const {
    out.sample_rate_hz = sample_rate_hz_;
    out.paths = energy.paths;
    out.channels.resize(channels_.size());
    for (auto& samples : out.channels) samples.resize(length_samples_);

    const std::vector<Segment> segments = envelope(energy);
    const Bands wanted = wanted_energy(energy);
    std::vector<Bands> gain;
    for (const Channel& channel : channels_) gain.push_back(gains(channel, segments, wanted));

    std::vector<float> mixing(field_.triangle());
    std::vector<float> mixing_end(field_.triangle());
    std::vector<float> slope(field_.triangle());
    std::vector<float> noises(channels_.size() * kChunk_samples);
    std::size_t filled = 0;
    for (const Segment& s : segments) {
        const std::size_t begin = first_sample(s.begin_cell);
        const std::size_t end = std::min(first_sample(s.end_cell), length_samples_);
        if (begin >= end) break;
        filled = end;
        if (&s == &segments.front()) field_.mixing(s.direction, mixing.data());
        field_.mixing(s.direction_end, mixing_end.data());
        const auto per_sample =
            static_cast<float>(1 / (start_samples(s.end_cell) - start_samples(s.begin_cell)));
        for (std::size_t i = 0; i < slope.size(); ++i) {
            slope[i] = (mixing_end[i] - mixing[i]) * per_sample;
        }
        for (std::size_t first = begin; first < end; first += kChunk_samples) {
            const std::size_t count = std::min(kChunk_samples, end - first);
            const float offset = middle(first, s.begin_cell);
            std::array<const float*, 16> noise{};
            for (std::size_t c = 0; c < channels_.size(); ++c) {
                std::array<const std::int16_t*, kBandCount> carrier{};
                for (std::size_t b = 0; b < kBandCount; ++b) {
                    carrier[b] = channels_[c].carriers[b].data() + first;
                }
                float* const shaped = noises.data() + c * kChunk_samples;
                const Bands scale = gain[c] * channels_[c].step;
                shape(count, offset, {s.amplitude.level * scale, s.amplitude.slope * scale},
                      carrier, shaped);
                noise[c] = shaped;
            }
            for (std::size_t c = 0; c < channels_.size(); ++c) {
                const std::size_t row = c * (c + 1) / 2;
                mix(count, offset, c + 1, mixing.data() + row, slope.data() + row, noise,
                    out.channels[c].data() + first);
            }
        }
        mixing.swap(mixing_end);
    }
    for (auto& samples : out.channels) {
        std::fill(samples.begin() + static_cast<std::ptrdiff_t>(filled), samples.end(), 0.0F);
    }
}

}  // namespace aula
