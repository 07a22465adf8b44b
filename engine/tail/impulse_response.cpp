#include "aula/engine/impulse_response.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstring>
#include <map>
#include <mutex>
#include <span>
#include <utility>

#include "engine/response/third_octave_model.h"
#include "engine/tail/carrier_interpolator.h"
#include "engine/tail/directional_covariance.h"
#include "engine/tail/noise_carriers.h"
#include "engine/tail/tail_envelope.h"
#include "process/multiversion.h"

namespace aula {
namespace {

using Values = NoiseCarriers::Values;

constexpr std::size_t kCarriers = NoiseCarriers::kCount;
constexpr std::size_t kHigh = NoiseCarriers::kHigh;
/// Third octaves within the octaves: of those above, no octave has the exact energy.
constexpr std::size_t kInOctaves = 3 * kBandCount;

// Samples shaped at a time: those of all channels fit the cache.
constexpr std::size_t kChunk_samples = NoiseCarriers::kMaxRead_samples;

// A carrier below the error of quantisation of the loudest of its segment, -88 dB, is left out.
constexpr float kInaudible = 4e-5F;

/// Samples that are shaped together.
constexpr std::size_t kLanes = 16;
using Lanes = float __attribute__((vector_size(kLanes * sizeof(float))));
using Integers = std::int16_t __attribute__((vector_size(kLanes * sizeof(std::int16_t))));
static_assert(kChunk_samples % kLanes == 0);

/// A carrier with a linear envelope.
struct Line {
    const std::int16_t* carrier;
    float level;  ///< at time 0
    float slope;  ///< per sample
};

struct Lines {
    std::size_t count = 0;
    std::array<Line, kCarriers> line;
};

// out[j] += sum over the lines of (level + slope (j + offset)) carrier[j], up to the next multiple
// of kLanes.
AULA_MULTIVERSION void shape(std::size_t count, float offset, const Lines& lines, float* out) {
    Lanes t;
    for (std::size_t k = 0; k < kLanes; ++k) t[k] = static_cast<float>(k) + offset;
    for (std::size_t j = 0; j < count; j += kLanes) {
        Lanes sum;
        std::memcpy(&sum, out + j, sizeof sum);
        for (std::size_t l = 0; l < lines.count; ++l) {
            const Line& line = lines.line[l];
            Integers carrier;
            std::memcpy(&carrier, line.carrier + j, sizeof carrier);
            sum += (line.level + line.slope * t) * __builtin_convertvector(carrier, Lanes);
        }
        std::memcpy(out + j, &sum, sizeof sum);
        t += static_cast<float>(kLanes);
    }
}

// out = sum over the rows of (level + slope t) in, the same for a row of a triangle.
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

/// Moments of a channel's carriers c over a segment of the envelope: the sums of c^2, c^2 t and
/// c^2 t^2, t from 0 at the segment's start to 1 at its end, and that of the product with the next
/// carrier of the octave. The energy of an octave with linear envelopes follows from them without a
/// pass over its samples.
struct Moments {
    Values zeroth{}, first{}, second{}, product{};
};

/// Sums over the segments of the energies of carriers, and of those that they have in common with
/// the next ones.
struct Energies {
    std::array<double, kCarriers> own{}, common{};
};

/// Adds the energies over a segment. The common ones are small: the middle of the envelopes
/// suffices.
AULA_MULTIVERSION void add_energies(const TailSegment& s, const Moments& m, Energies& sum) {
    Values middle;
    for (std::size_t k = 0; k < kCarriers; ++k) {
        const float rise = s.end[k] - s.begin[k];
        const float energy = s.begin[k] * s.begin[k] * m.zeroth[k] +
                             s.begin[k] * rise * m.first[k] * 2.0F + rise * rise * m.second[k];
        sum.own[k] += double{energy};
        middle[k] = 0.5F * (s.begin[k] + s.end[k]);
    }
    for (std::size_t k = 0; k + 1 < kCarriers; ++k)
        sum.common[k] += double{2 * middle[k] * middle[k + 1] * m.product[k]};
}

struct Channel {
    std::size_t offset = 0;        ///< start of its carriers
    std::vector<Moments> moments;  ///< [segment]
};

}  // namespace

struct ImpulseResponseBuilder::State {
    State(std::shared_ptr<const NoiseCarriers> carriers, const Medium& medium, double length_s,
          std::string_view source, int ambisonic_order);
    Bands wanted_energy(const EnergyResponse& energy) const;
    void measure_carriers(const TimeBins& bins, const std::vector<TailSegment>& segments);
    Moments moments(const Channel& channel, const TailSegment& segment) const;
    Values gains(const Channel& channel, const std::vector<TailSegment>& segments,
                 const Bands& wanted) const;
    void build(const EnergyResponse& energy, ImpulseResponse& out);
    void shape_low(const Channel& channel, const std::vector<TailSegment>& segments,
                   const Values& gain, std::vector<float>& out);
    void set_lines(const TailSegment& segment, const Channel& channel, const Values& gain,
                   bool is_low, std::size_t first);

    double start_samples(double time_s) const { return time_s * carriers_->sample_rate_hz(); }
    /// The first sample from a time on; a time that is whole but for rounding is that sample.
    std::size_t first_sample(double time_s) const {
        return static_cast<std::size_t>(std::ceil(start_samples(time_s) - 1e-6));
    }
    /// The middle of a sample from a time on, in samples.
    float middle(std::size_t sample, double time_s) const {
        return static_cast<float>(static_cast<double>(sample) + 0.5 - start_samples(time_s));
    }

    std::shared_ptr<const NoiseCarriers> carriers_;
    std::size_t length_samples_;
    ThirdOctaveModel model_;
    DirectionalCovariance covariance_;
    CarrierInterpolator interpolator_;
    std::vector<Channel> channels_;  ///< before mixing
    TimeBins bins_;                  ///< time axis of the moments
    std::vector<float> low_;         ///< work space: the sum of the low carriers of a channel
    Lines lines_;                    ///< work space
};

ImpulseResponseBuilder::State::State(std::shared_ptr<const NoiseCarriers> carriers,
                                     const Medium& medium, double length_s, std::string_view source,
                                     int ambisonic_order)
    : carriers_(std::move(carriers)),
      length_samples_(
          static_cast<std::size_t>(std::ceil(length_s * carriers_->sample_rate_hz() - 1e-6))),
      model_(medium),
      covariance_(ambisonic_order),
      interpolator_(carriers_->decimation()),
      channels_(covariance_.channels()) {
    assert(length_s > 0);
    for (std::size_t c = 0; c < channels_.size(); ++c) {
        channels_[c].offset = carriers_->offset(source, c);
    }
}

/// The target sum of squares of each octave of a channel.
Bands ImpulseResponseBuilder::State::wanted_energy(const EnergyResponse& energy) const {
    const double length_s = static_cast<double>(length_samples_) / carriers_->sample_rate_hz();
    std::array<double, kBandCount> sum{};
    for (std::size_t i = 0; i < energy.bins.count(); ++i) {
        const double begin_s = energy.bins.begin_s(i);
        const double width_s = energy.bins.end_s(i) - begin_s;
        const double inside = std::clamp((length_s - begin_s) / width_s, 0.0, 1.0);
        for (std::size_t b = 0; b < kBandCount; ++b) sum[b] += inside * double{energy.energy[i][b]};
    }
    std::array<double, kBandCount> power{};
    for (std::size_t k = 0; k < kInOctaves; ++k) power[k / 3] += double{carriers_->power()[k]};
    Bands wanted;
    for (std::size_t b = 0; b < kBandCount; ++b)
        wanted[b] = static_cast<float>(power[b] * squared_pressure(1.0) * sum[b]);
    return wanted;
}

/// The moments of a channel's carriers over a segment, up to the end of the response.
Moments ImpulseResponseBuilder::State::moments(const Channel& channel,
                                               const TailSegment& segment) const {
    Moments m;
    const double duration = start_samples(segment.end_s) - start_samples(segment.begin_s);
    for (std::size_t k = 0; k < kCarriers; ++k) {
        const bool is_low = k < kHigh;
        const bool has_next = k < kInOctaves && k % 3 != 2;
        const std::size_t step = is_low ? carriers_->decimation() : 1;
        const auto rounded_up = [step](std::size_t sample) { return (sample + step - 1) / step; };
        const std::size_t begin = rounded_up(first_sample(segment.begin_s));
        const std::size_t end = rounded_up(std::min(first_sample(segment.end_s), length_samples_));
        std::array<double, 4> sum{};
        for (std::size_t first = begin; first < end; first += kChunk_samples) {
            const std::size_t position = carriers_->position(is_low, channel.offset, first);
            const std::int16_t* const carrier = carriers_->read(k, position);
            const std::int16_t* const next = carriers_->read(has_next ? k + 1 : k, position);
            for (std::size_t j = 0; j < std::min(kChunk_samples, end - first); ++j) {
                const auto x = static_cast<double>(carrier[j]);
                const double power = x * x;
                const double t = double{middle((first + j) * step, segment.begin_s)} / duration;
                sum[0] += power;
                sum[1] += power * t;
                sum[2] += power * t * t;
                sum[3] += x * static_cast<double>(next[j]);
            }
        }
        const double unit = double{carriers_->step()[k]} * static_cast<double>(step);
        const double square = unit * double{carriers_->step()[k]};
        m.zeroth[k] = static_cast<float>(square * sum[0]);
        m.first[k] = static_cast<float>(square * sum[1]);
        m.second[k] = static_cast<float>(square * sum[2]);
        if (has_next)
            m.product[k] = static_cast<float>(unit * double{carriers_->step()[k + 1]} * sum[3]);
    }
    return m;
}

/// Segments depend on the bins only, so the moments are valid until the bins change.
void ImpulseResponseBuilder::State::measure_carriers(const TimeBins& bins,
                                                     const std::vector<TailSegment>& segments) {
    if (bins == bins_) return;
    bins_ = bins;
    for (Channel& channel : channels_) {
        channel.moments.clear();
        channel.moments.reserve(segments.size());
        for (const TailSegment& s : segments) channel.moments.push_back(moments(channel, s));
    }
}

/// The factors of the carriers of a channel that give each octave the sum of squares `wanted`.
Values ImpulseResponseBuilder::State::gains(const Channel& channel,
                                            const std::vector<TailSegment>& segments,
                                            const Bands& wanted) const {
    Energies sum;
    for (std::size_t i = 0; i < segments.size(); ++i)
        best_version<add_energies>(segments[i], channel.moments[i], sum);
    Values gain{};
    for (std::size_t b = 0; b < kBandCount; ++b) {
        double energy = 0;
        for (std::size_t k = 3 * b; k < 3 * b + 3; ++k) energy += sum.own[k] + sum.common[k];
        if (!(energy > 0)) continue;
        const auto factor = static_cast<float>(std::sqrt(double{wanted[b]} / energy));
        for (std::size_t k = 3 * b; k < 3 * b + 3; ++k) gain[k] = factor * carriers_->step()[k];
    }
    for (std::size_t k = kInOctaves; k < kCarriers; ++k) gain[k] = carriers_->step()[k];
    return gain;
}

/// Sets the audible lines of a segment from the sample `first` of the carriers on.
void ImpulseResponseBuilder::State::set_lines(const TailSegment& segment, const Channel& channel,
                                              const Values& gain, bool is_low, std::size_t first) {
    const double duration = start_samples(segment.end_s) - start_samples(segment.begin_s);
    const auto per_sample =
        static_cast<float>(static_cast<double>(is_low ? carriers_->decimation() : 1) / duration);
    const std::size_t position = carriers_->position(is_low, channel.offset, first);
    lines_.count = 0;
    for (std::size_t k = is_low ? 0 : kHigh; k < (is_low ? kHigh : kCarriers); ++k) {
        if (std::max(segment.begin[k], segment.end[k]) <= kInaudible * segment.loudest) continue;
        lines_.line[lines_.count++] = {carriers_->read(k, position), gain[k] * segment.begin[k],
                                       gain[k] * (segment.end[k] - segment.begin[k]) * per_sample};
    }
}

/// The low carriers of a channel at the full rate.
void ImpulseResponseBuilder::State::shape_low(const Channel& channel,
                                              const std::vector<TailSegment>& segments,
                                              const Values& gain, std::vector<float>& out) {
    const std::size_t step = carriers_->decimation();
    const auto rounded_up = [step](std::size_t sample) { return (sample + step - 1) / step; };
    const std::size_t count = rounded_up(length_samples_) + CarrierInterpolator::kAfter;
    low_.assign(CarrierInterpolator::kBefore + count, 0);
    for (const TailSegment& s : segments) {
        const std::size_t begin = rounded_up(first_sample(s.begin_s));
        const std::size_t end = std::min(rounded_up(first_sample(s.end_s)), count);
        for (std::size_t first = begin; first < end; first += kChunk_samples) {
            const std::size_t samples = std::min(kChunk_samples, end - first);
            std::array<float, kChunk_samples> sum;
            std::fill_n(sum.begin(), samples, 0.0F);
            set_lines(s, channel, gain, true, first);
            best_version<shape>(samples, middle(first * step, s.begin_s) / static_cast<float>(step),
                                lines_, sum.data());
            std::copy_n(
                sum.begin(), samples,
                low_.begin() + static_cast<std::ptrdiff_t>(CarrierInterpolator::kBefore + first));
        }
    }
    // The last samples of the low carriers may end beyond the response.
    out.resize(rounded_up(length_samples_) * step);
    interpolator_.process(low_.data(), rounded_up(length_samples_), out.data());
    out.resize(length_samples_);
}

// Every channel is first shaped with the energies of W. Then the channels are mixed to the field's
// covariance, with mixing matrices interpolated linearly between the ends of segments.
void ImpulseResponseBuilder::State::build(const EnergyResponse& energy, ImpulseResponse& out) {
    out.sample_rate_hz = carriers_->sample_rate_hz();
    out.paths = energy.paths;
    out.channels.resize(channels_.size());

    const std::vector<TailSegment> segments =
        tail_envelope(energy, model_, carriers_->sample_rate_hz());
    measure_carriers(energy.bins, segments);
    const Bands wanted = wanted_energy(energy);
    std::vector<Values> gain;
    for (std::size_t c = 0; c < channels_.size(); ++c) {
        gain.push_back(gains(channels_[c], segments, wanted));
        shape_low(channels_[c], segments, gain[c], out.channels[c]);
    }

    std::vector<float> mixing(covariance_.triangle());
    std::vector<float> mixing_end(covariance_.triangle());
    std::vector<float> slope(covariance_.triangle());
    std::vector<float> noises(channels_.size() * kChunk_samples);
    std::size_t filled = 0;
    for (const TailSegment& s : segments) {
        const std::size_t begin = first_sample(s.begin_s);
        const std::size_t end = std::min(first_sample(s.end_s), length_samples_);
        if (begin >= end) break;
        filled = end;
        if (&s == &segments.front()) covariance_.mixing(s.direction, mixing.data());
        covariance_.mixing(s.direction_end, mixing_end.data());
        const auto per_sample =
            static_cast<float>(1 / (start_samples(s.end_s) - start_samples(s.begin_s)));
        for (std::size_t i = 0; i < slope.size(); ++i) {
            slope[i] = (mixing_end[i] - mixing[i]) * per_sample;
        }
        for (std::size_t first = begin; first < end; first += kChunk_samples) {
            const std::size_t count = std::min(kChunk_samples, end - first);
            const float offset = middle(first, s.begin_s);
            std::array<const float*, 16> noise{};
            for (std::size_t c = 0; c < channels_.size(); ++c) {
                float* const shaped = noises.data() + c * kChunk_samples;
                noise[c] = shaped;
                // Interpolation rings before the first arrival.
                if (s.loudest == 0) {
                    std::fill_n(shaped, count, 0.0F);
                    continue;
                }
                std::copy_n(out.channels[c].data() + first, count, shaped);
                set_lines(s, channels_[c], gain[c], false, first);
                best_version<shape>(count, offset, lines_, shaped);
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

// 11 MB at 48 kHz: all rooms of a process share the carriers of a rate and a seed.
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
                                               const Medium& medium, double length_s,
                                               std::string_view source, int ambisonic_order)
    : state_(std::make_unique<State>(std::move(carriers), medium, length_s, source,
                                     ambisonic_order)) {}
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
    std::size_t bytes = sizeof(State) + channels.capacity() * sizeof(Channel) +
                        state_->low_.capacity() * sizeof(float);
    for (const Channel& c : channels) bytes += c.moments.capacity() * sizeof(Moments);
    return bytes;
}

}  // namespace aula
