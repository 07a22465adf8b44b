#include "aula/engine/impulse_response.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <mutex>
#include <utility>

#include "engine/response/directional_covariance.h"
#include "engine/response/noise_carriers.h"
#include "process/multiversion.h"

namespace aula {
namespace {

constexpr double kCell_s = 0.0005;  // edges and centres of all TimeBins are multiples of it
// Samples shaped at a time: those of all channels fit the cache.
constexpr std::size_t kChunk_samples = NoiseCarriers::kMaxRead_samples;

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

// A faster change than about a period of the centre frequency would spread a carrier's spectrum
// into other octaves. A bin's energy is therefore spread over its duration and a period after it (1
// ms at 1 kHz, 16 ms at 63 Hz: less than the duration of the octave filter's response).
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

/// A piece of the envelope between two cells' starts.
struct Segment {
    std::size_t begin_cell, end_cell;
    Ramp amplitude;      ///< pressure over a carrier of unit variance
    Vec3 direction;      ///< energy-weighted mean at the start
    Vec3 direction_end;  ///< at the end
};

/// Moments of the power of a channel's carriers over a segment of the envelope: the sums of c^2,
/// c^2 t and c^2 t^2, t in samples from the segment's start. The energy of a carrier with a linear
/// envelope follows from them without a pass over its samples.
struct Moments {
    Bands zeroth, first, second;
};

struct Channel {
    std::size_t offset = 0;        ///< start of its carriers
    std::vector<Moments> moments;  ///< [segment]
};

}  // namespace

struct ImpulseResponseBuilder::State {
    State(std::shared_ptr<const NoiseCarriers> carriers, double length_s, std::string_view source,
          int ambisonic_order);
    std::vector<Segment> envelope(const EnergyResponse& energy) const;
    Bands wanted_energy(const EnergyResponse& energy) const;
    void measure_carriers(const TimeBins& bins, const std::vector<Segment>& segments);
    Moments moments(const Channel& channel, const Segment& segment) const;
    Bands gains(const Channel& channel, const std::vector<Segment>& segments,
                const Bands& wanted) const;
    void build(const EnergyResponse& energy, ImpulseResponse& out);

    double start_samples(std::size_t cell) const;
    std::size_t first_sample(std::size_t cell) const;
    float middle(std::size_t sample, std::size_t cell) const;

    std::shared_ptr<const NoiseCarriers> carriers_;
    std::size_t length_samples_;
    DirectionalCovariance covariance_;
    std::vector<Channel> channels_;  ///< before mixing
    TimeBins bins_;                  ///< time axis of the moments
};

ImpulseResponseBuilder::State::State(std::shared_ptr<const NoiseCarriers> carriers, double length_s,
                                     std::string_view source, int ambisonic_order)
    : carriers_(std::move(carriers)),
      length_samples_(
          static_cast<std::size_t>(std::ceil(length_s * carriers_->sample_rate_hz() - 1e-6))),
      covariance_(ambisonic_order),
      channels_(covariance_.channels()) {
    assert(length_s > 0);
    for (std::size_t c = 0; c < channels_.size(); ++c) {
        channels_[c].offset = carriers_->offset(source, c);
    }
}

/// Start of a cell, samples.
double ImpulseResponseBuilder::State::start_samples(std::size_t cell) const {
    return static_cast<double>(cell) * kCell_s * carriers_->sample_rate_hz();
}

/// The first sample of a cell; a start that is whole but for rounding is that sample.
std::size_t ImpulseResponseBuilder::State::first_sample(std::size_t cell) const {
    return static_cast<std::size_t>(std::ceil(start_samples(cell) - 1e-6));
}

/// The middle of a sample from the start of a cell, in samples.
float ImpulseResponseBuilder::State::middle(std::size_t sample, std::size_t cell) const {
    return static_cast<float>(static_cast<double>(sample) + 0.5 - start_samples(cell));
}

// The amplitude is continuous and linear between the edges and the centre of each bin. With a^2 the
// mean power of the bin, e0 and e1 the amplitudes at its edges and c that at its centre, the energy
// of the bin is preserved if
//     [(e0^2 + e0 c + c^2) + (c^2 + c e1 + e1^2)] / 6 = a^2, that is
//     c = (sqrt(s^2 + 8 (6 a^2 - q)) - s) / 4,   s = e0 + e1, q = e0^2 + e1^2.
// The amplitude at an edge is the geometric mean of both bins' amplitudes (exact for an exponential
// decay), but at most sqrt(3) times the lower one: then q <= 6 a^2 and c is real.
std::vector<Segment> ImpulseResponseBuilder::State::envelope(const EnergyResponse& energy) const {
    const TimeBins& bins = energy.bins;
    const auto cell_at = [](double time_s) {
        return static_cast<std::size_t>(std::lround(time_s / kCell_s));
    };
    const std::vector<Bands> spread_energy = spread_in_time(energy);
    // Edge, centre, edge, centre .. edge; silence before and after the response.
    std::vector<Knot> knots;
    knots.reserve(2 * bins.count() + 1);
    Bands before;
    Vec3 intensity_before{0};
    float energy_before = 0;
    for (std::size_t i = 0; i <= bins.count(); ++i) {
        const bool inside = i < bins.count();
        Bands a;
        const Vec3 intensity = inside ? energy.intensity[i] : Vec3{0};
        const float sum = inside ? energy.energy[i].sum() : 0;
        if (inside) {
            // The squared pressure is spread over the bin's samples.
            const double samples = (bins.end_s(i) - bins.begin_s(i)) * carriers_->sample_rate_hz();
            const auto k = static_cast<float>(squared_pressure(1.0) / samples);
            for (std::size_t b = 0; b < kBandCount; ++b) a[b] = std::sqrt(k * spread_energy[i][b]);
        }
        Knot edge{cell_at(inside ? bins.begin_s(i) : bins.length_s()), {}, Vec3{0}};
        for (std::size_t b = 0; b < kBandCount; ++b) {
            edge.amplitude[b] =
                std::min(std::sqrt(before[b] * a[b]), std::sqrt(3.0F) * std::min(before[b], a[b]));
        }
        if (sum + energy_before > 0) {
            edge.direction = (intensity_before + intensity) / (energy_before + sum);
        } else if (i > 0) {
            edge.direction = knots.back().direction;  // spread energy keeps its direction
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
        knots.push_back({cell_at(centre_s), {}, sum > 0 ? intensity / sum : edge.direction});
        before = a;
        intensity_before = intensity;
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

/// The target sum of squares of each band of a channel.
Bands ImpulseResponseBuilder::State::wanted_energy(const EnergyResponse& energy) const {
    const double length_s = static_cast<double>(length_samples_) / carriers_->sample_rate_hz();
    std::array<double, kBandCount> sum{};
    for (std::size_t i = 0; i < energy.bins.count(); ++i) {
        const double begin_s = energy.bins.begin_s(i);
        const double width_s = energy.bins.end_s(i) - begin_s;
        const double inside = std::clamp((length_s - begin_s) / width_s, 0.0, 1.0);
        for (std::size_t b = 0; b < kBandCount; ++b) sum[b] += inside * double{energy.energy[i][b]};
    }
    Bands wanted;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        wanted[b] =
            static_cast<float>(double{carriers_->power()[b]} * squared_pressure(1.0) * sum[b]);
    }
    return wanted;
}

/// The moments of a channel's carriers over a segment, up to the end of the response.
Moments ImpulseResponseBuilder::State::moments(const Channel& channel,
                                               const Segment& segment) const {
    Moments m;
    const std::size_t begin = first_sample(segment.begin_cell);
    const std::size_t end = std::min(first_sample(segment.end_cell), length_samples_);
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const double unit{carriers_->step()[b]};
        std::array<double, 3> sum{};
        for (std::size_t first = begin; first < end; first += kChunk_samples) {
            const std::int16_t* const carrier = carriers_->read(b, channel.offset, first);
            const double offset{middle(first, segment.begin_cell)};
            for (std::size_t j = 0; j < std::min(kChunk_samples, end - first); ++j) {
                const auto x = static_cast<double>(carrier[j]);
                const double power = x * x;
                const double t = static_cast<double>(j) + offset;
                sum[0] += power;
                sum[1] += power * t;
                sum[2] += power * t * t;
            }
        }
        m.zeroth[b] = static_cast<float>(unit * unit * sum[0]);
        m.first[b] = static_cast<float>(unit * unit * sum[1]);
        m.second[b] = static_cast<float>(unit * unit * sum[2]);
    }
    return m;
}

/// Segments depend on the bins only, so the moments are valid until the bins change.
void ImpulseResponseBuilder::State::measure_carriers(const TimeBins& bins,
                                                     const std::vector<Segment>& segments) {
    if (bins == bins_) return;
    bins_ = bins;
    for (Channel& channel : channels_) {
        channel.moments.clear();
        channel.moments.reserve(segments.size());
        for (const Segment& s : segments) channel.moments.push_back(moments(channel, s));
    }
}

/// The gain of each band of a channel such that its squares sum to `wanted`.
Bands ImpulseResponseBuilder::State::gains(const Channel& channel,
                                           const std::vector<Segment>& segments,
                                           const Bands& wanted) const {
    std::array<double, kBandCount> sum{};
    for (std::size_t i = 0; i < segments.size(); ++i) {
        // The sum of (level + slope t)^2 c^2.
        const Bands& level = segments[i].amplitude.level;
        const Bands& slope = segments[i].amplitude.slope;
        const Moments& m = channel.moments[i];
        const Bands energy =
            level * level * m.zeroth + level * slope * m.first * 2.0F + slope * slope * m.second;
        for (std::size_t b = 0; b < kBandCount; ++b) sum[b] += double{energy[b]};
    }
    Bands gain;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        if (sum[b] > 0) gain[b] = static_cast<float>(std::sqrt(double{wanted[b]} / sum[b]));
    }
    return gain;
}

// Every channel is first shaped with the energies of W. Then the channels are mixed to the field's
// covariance, with mixing matrices interpolated linearly between knots.
void ImpulseResponseBuilder::State::build(const EnergyResponse& energy, ImpulseResponse& out) {
    out.sample_rate_hz = carriers_->sample_rate_hz();
    out.paths = energy.paths;
    out.channels.resize(channels_.size());
    for (auto& samples : out.channels) samples.resize(length_samples_);

    const std::vector<Segment> segments = envelope(energy);
    measure_carriers(energy.bins, segments);
    const Bands wanted = wanted_energy(energy);
    std::vector<Bands> gain;
    for (const Channel& channel : channels_) gain.push_back(gains(channel, segments, wanted));

    std::vector<float> mixing(covariance_.triangle());
    std::vector<float> mixing_end(covariance_.triangle());
    std::vector<float> slope(covariance_.triangle());
    std::vector<float> noises(channels_.size() * kChunk_samples);
    std::size_t filled = 0;
    for (const Segment& s : segments) {
        const std::size_t begin = first_sample(s.begin_cell);
        const std::size_t end = std::min(first_sample(s.end_cell), length_samples_);
        if (begin >= end) break;
        filled = end;
        if (&s == &segments.front()) covariance_.mixing(s.direction, mixing.data());
        covariance_.mixing(s.direction_end, mixing_end.data());
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
                    carrier[b] = carriers_->read(b, channels_[c].offset, first);
                }
                float* const shaped = noises.data() + c * kChunk_samples;
                const Bands scale = gain[c] * carriers_->step();
                best_version<shape>(count, offset,
                                    Ramp{s.amplitude.level * scale, s.amplitude.slope * scale},
                                    carrier, shaped);
                noise[c] = shaped;
            }
            for (std::size_t c = 0; c < channels_.size(); ++c) {
                const std::size_t row = c * (c + 1) / 2;
                best_version<mix>(count, offset, c + 1, mixing.data() + row, slope.data() + row,
                                  noise, out.channels[c].data() + first);
            }
        }
        mixing.swap(mixing_end);
    }
    for (auto& samples : out.channels) {
        std::fill(samples.begin() + static_cast<std::ptrdiff_t>(filled), samples.end(), 0.0F);
    }
}

// 6 MB at 48 kHz: all rooms of a process share the carriers of a rate and a seed.
std::shared_ptr<const NoiseCarriers> make_noise_carriers(double sample_rate_hz,
                                                         std::uint64_t seed) {
    static std::mutex mutex;
    static std::map<std::pair<double, std::uint64_t>, std::weak_ptr<const NoiseCarriers>> all;
    const std::lock_guard lock(mutex);
    std::erase_if(all, [](const auto& entry) { return entry.second.expired(); });
    std::weak_ptr<const NoiseCarriers>& present = all[{sample_rate_hz, seed}];
    auto carriers = present.lock();
    if (!carriers) {
        // Not in one block with the reference counts: a weak pointer would keep the memory.
        carriers.reset(new NoiseCarriers(sample_rate_hz, seed));
        present = carriers;
    }
    return carriers;
}

ImpulseResponseBuilder::ImpulseResponseBuilder(std::shared_ptr<const NoiseCarriers> carriers,
                                               double length_s, std::string_view source,
                                               int ambisonic_order)
    : state_(std::make_unique<State>(std::move(carriers), length_s, source, ambisonic_order)) {}
ImpulseResponseBuilder::~ImpulseResponseBuilder() = default;
ImpulseResponseBuilder::ImpulseResponseBuilder(ImpulseResponseBuilder&&) noexcept = default;
ImpulseResponseBuilder& ImpulseResponseBuilder::operator=(ImpulseResponseBuilder&&) noexcept =
    default;

void ImpulseResponseBuilder::build(const EnergyResponse& energy, ImpulseResponse& out) {
    state_->build(energy, out);
}

std::size_t ImpulseResponseBuilder::length_samples() const { return state_->length_samples_; }

std::size_t ImpulseResponseBuilder::memory_bytes() const {
    const std::vector<Channel>& channels = state_->channels_;
    std::size_t bytes = sizeof(State) + channels.capacity() * sizeof(Channel);
    for (const Channel& c : channels) bytes += c.moments.capacity() * sizeof(Moments);
    return bytes;
}

}  // namespace aula
