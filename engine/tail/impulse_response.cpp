#include "aula/engine/impulse_response.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstring>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "engine/base/wave_masks.h"
#include "engine/response/third_octave_model.h"
#include "engine/tail/carrier_interpolator.h"
#include "engine/tail/carrier_moments.h"
#include "engine/tail/directional_covariance.h"
#include "engine/tail/noise_carriers.h"
#include "engine/tail/plane_wave_tail.h"
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

/// The amplitudes of the carriers above a crossover, [carrier].
Values amplitudes_above(double crossover_hz) {
    Values amplitudes;
    amplitudes.fill(1);
    if (!(crossover_hz > 0)) return amplitudes;
    constexpr int kPoints = 8;  // of a third octave
    for (std::size_t k = 0; k < amplitudes.size(); ++k) {
        double power = 0;
        for (int i = 0; i < kPoints; ++i) {
            const double octaves = ((i + 0.5) / kPoints - 0.5) / 3;
            const double amplitude =
                WaveMasks{crossover_hz}.high(ThirdOctaveModel::centre_hz(k) * std::exp2(octaves));
            power += amplitude * amplitude / kPoints;
        }
        amplitudes[k] = static_cast<float>(std::sqrt(power));
    }
    return amplitudes;
}

/// Moments of a channel's high carriers c over a segment of the envelope: the sums of c^2, c^2 t
/// and c^2 t^2, t from 0 at the segment's start to 1 at its end, and that of the product with the
/// next carrier of the octave. The energy of an octave with linear envelopes follows from them
/// without a pass over its samples.
struct Moments {
    std::array<float, kCarriers - kHigh> zeroth{}, first{}, second{}, product{};
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
    for (std::size_t k = kHigh; k < kCarriers; ++k) {
        const float rise = s.end[k] - s.begin[k];
        const float energy = s.begin[k] * s.begin[k] * m.zeroth[k - kHigh] +
                             s.begin[k] * rise * m.first[k - kHigh] * 2.0F +
                             rise * rise * m.second[k - kHigh];
        sum.own[k] += double{energy};
        middle[k] = 0.5F * (s.begin[k] + s.end[k]);
    }
    for (std::size_t k = kHigh; k + 1 < kCarriers; ++k)
        sum.common[k] += double{2 * middle[k] * middle[k + 1] * m.product[k - kHigh]};
}

/// Shares of the low and of the high carriers in the energies of octaves.
struct OctaveShares {
    Bands low, high;
};

struct Channel {
    std::size_t offset = 0;        ///< start of its high carriers
    std::vector<Moments> moments;  ///< [segment]
};

}  // namespace

struct ImpulseResponseBuilder::State {
    State(std::shared_ptr<const NoiseCarriers> carriers, const Medium& medium, double length_s,
          std::string_view source, int ambisonic_order);
    Bands wanted_energy(const EnergyResponse& energy) const;
    void begin_room(std::uint64_t room);
    void measure_carriers(const TimeBins& bins, const std::vector<TailSegment>& segments);
    Moments moments(const Channel& channel, const TailSegment& segment) const;
    Values gains(const Channel& channel, const std::vector<TailSegment>& segments,
                 const Bands& wanted) const;
    void build(const EnergyResponse& energy, ImpulseResponse& out, double crossover_hz,
               TailScale& scale, std::size_t samples);
    OctaveShares shares(const std::vector<TailSegment>& segments, const Values& above) const;
    bool has_scale(const TailScale& scale, const Bands& wanted) const;
    void set_scale(std::size_t channel, const Bands& wanted, TailScale& scale) const;
    void add_low(std::size_t channel, const TailScale& scale, std::vector<float>& out);
    void set_lines(const TailSegment& segment, const Channel& channel, const Values& gain,
                   std::size_t first);
    /// Samples of the low carriers in so many of a response.
    std::size_t low_samples(std::size_t samples) const {
        return (samples + carriers_->decimation() - 1) / carriers_->decimation();
    }

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
    std::string source_;
    ThirdOctaveModel model_;
    DirectionalCovariance covariance_;
    CarrierInterpolator interpolator_;
    std::optional<std::uint64_t> room_;   ///< that the carriers are selected for
    std::optional<PlaneWaveTail> waves_;  ///< the low carriers
    std::vector<Channel> channels_;       ///< before mixing
    TimeBins bins_;                       ///< time axis of the moments
    std::vector<float> low_;              ///< work space: the sum of the low carriers of a channel
    Lines lines_;                         ///< work space
};

ImpulseResponseBuilder::State::State(std::shared_ptr<const NoiseCarriers> carriers,
                                     const Medium& medium, double length_s, std::string_view source,
                                     int ambisonic_order)
    : carriers_(std::move(carriers)),
      length_samples_(
          static_cast<std::size_t>(std::ceil(length_s * carriers_->sample_rate_hz() - 1e-6))),
      source_(source),
      model_(medium),
      covariance_(ambisonic_order),
      interpolator_(carriers_->decimation()),
      channels_(covariance_.channels()) {
    assert(length_s > 0);
}

/// Selects the carriers.
void ImpulseResponseBuilder::State::begin_room(std::uint64_t room) {
    if (room_ == room) return;
    room_ = room;
    bins_ = {};
    for (std::size_t c = 0; c < channels_.size(); ++c)
        channels_[c].offset = carriers_->offset(room, source_, c);
    waves_.emplace(carriers_, channels_.size(),
                   low_samples(length_samples_) + CarrierInterpolator::kAfter,
                   carriers_->waves_seed(room, source_));
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
    const std::size_t begin = first_sample(segment.begin_s);
    const std::size_t end = std::min(first_sample(segment.end_s), length_samples_);
    for (std::size_t k = kHigh; k < kCarriers; ++k) {
        const bool has_next = k < kInOctaves && k % 3 != 2;
        CarrierMoments sum;
        for (std::size_t first = begin; first < end; first += kChunk_samples) {
            const std::size_t position = carriers_->position(channel.offset, first);
            sum.add({carriers_->read(k, position), std::min(kChunk_samples, end - first)},
                    carriers_->read(has_next ? k + 1 : k, position),
                    middle(first, segment.begin_s) / static_cast<float>(duration),
                    static_cast<float>(1 / duration));
        }
        const double unit{carriers_->step()[k]};
        m.zeroth[k - kHigh] = static_cast<float>(unit * unit * sum.zeroth);
        m.first[k - kHigh] = static_cast<float>(unit * unit * sum.first);
        m.second[k - kHigh] = static_cast<float>(unit * unit * sum.second);
        if (has_next)
            m.product[k - kHigh] =
                static_cast<float>(unit * double{carriers_->step()[k + 1]} * sum.product);
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

/// The factors of the high carriers of a channel that give those of each octave the sum of squares
/// `wanted`.
Values ImpulseResponseBuilder::State::gains(const Channel& channel,
                                            const std::vector<TailSegment>& segments,
                                            const Bands& wanted) const {
    Energies sum;
    for (std::size_t i = 0; i < segments.size(); ++i)
        best_version<add_energies>(segments[i], channel.moments[i], sum);
    Values gain{};
    for (std::size_t b = kHigh / 3; b < kBandCount; ++b) {
        double energy = 0;
        const std::size_t first = std::max(3 * b, kHigh);
        for (std::size_t k = first; k < 3 * b + 3; ++k) energy += sum.own[k] + sum.common[k];
        if (!(energy > 0)) continue;
        const auto factor = static_cast<float>(std::sqrt(double{wanted[b]} / energy));
        for (std::size_t k = first; k < 3 * b + 3; ++k) gain[k] = factor * carriers_->step()[k];
    }
    for (std::size_t k = kInOctaves; k < kCarriers; ++k) gain[k] = carriers_->step()[k];
    return gain;
}

/// Sets the audible lines of a segment from the sample `first` on.
void ImpulseResponseBuilder::State::set_lines(const TailSegment& segment, const Channel& channel,
                                              const Values& gain, std::size_t first) {
    const double duration = start_samples(segment.end_s) - start_samples(segment.begin_s);
    const auto per_sample = static_cast<float>(1 / duration);
    const std::size_t position = carriers_->position(channel.offset, first);
    lines_.count = 0;
    for (std::size_t k = kHigh; k < kCarriers; ++k) {
        if (gain[k] == 0 || !segment.is_audible(k)) continue;
        lines_.line[lines_.count++] = {carriers_->read(k, position), gain[k] * segment.begin[k],
                                       gain[k] * (segment.end[k] - segment.begin[k]) * per_sample};
    }
}

/// The shares of low carriers with the amplitudes `above` in the energies of octaves, and those of
/// the high carriers.
OctaveShares ImpulseResponseBuilder::State::shares(const std::vector<TailSegment>& segments,
                                                   const Values& above) const {
    std::array<double, kInOctaves> energy{};
    for (const TailSegment& s : segments) {
        const double duration_s = s.end_s - s.begin_s;
        for (std::size_t k = 0; k < kInOctaves; ++k) {
            const float square =
                s.begin[k] * s.begin[k] + s.begin[k] * s.end[k] + s.end[k] * s.end[k];
            energy[k] += duration_s * double{square};
        }
    }
    OctaveShares shares;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        double all = 0;
        double low = 0;
        double high = 0;
        for (std::size_t k = 3 * b; k < 3 * b + 3; ++k) {
            const double own = energy[k] * double{carriers_->power()[k]};
            all += own;
            if (k < kHigh) {
                low += own * double{above[k] * above[k]};
            } else {
                high += own;
            }
        }
        if (!(all > 0)) continue;
        shares.low[b] = static_cast<float>(low / all);
        shares.high[b] = static_cast<float>(high / all);
    }
    return shares;
}

/// Whether there are factors of all low octaves that sound.
bool ImpulseResponseBuilder::State::has_scale(const TailScale& scale, const Bands& wanted) const {
    if (scale.gains.size() != channels_.size() * PlaneWaveTail::kOctaves) return false;
    for (std::size_t i = 0; i < scale.gains.size(); ++i)
        if (scale.gains[i] == 0 && wanted[i % PlaneWaveTail::kOctaves] > 0) return false;
    return true;
}

/// Sets the factors of a channel's low carriers that give each octave the sum of squares `wanted`.
void ImpulseResponseBuilder::State::set_scale(std::size_t channel, const Bands& wanted,
                                              TailScale& scale) const {
    scale.gains.resize(channels_.size() * PlaneWaveTail::kOctaves);
    const auto step = static_cast<double>(carriers_->decimation());
    for (std::size_t o = 0; o < PlaneWaveTail::kOctaves; ++o) {
        const std::vector<float>& sum = waves_->sum(o, channel);
        double energy = 0;
        for (std::size_t n = 0; n < low_samples(length_samples_); ++n)
            energy += double{sum[n]} * double{sum[n]};
        scale.gains[channel * PlaneWaveTail::kOctaves + o] =
            energy > 0 ? static_cast<float>(std::sqrt(double{wanted[o]} / (energy * step))) : 0;
    }
}

/// The low carriers of a channel at the full rate, as many samples as `out` has.
void ImpulseResponseBuilder::State::add_low(std::size_t channel, const TailScale& scale,
                                            std::vector<float>& out) {
    const std::size_t samples = out.size();
    const std::size_t low = low_samples(samples);
    low_.assign(CarrierInterpolator::kBefore + low + CarrierInterpolator::kAfter, 0);
    for (std::size_t o = 0; o < PlaneWaveTail::kOctaves; ++o) {
        const float gain = scale.gains[channel * PlaneWaveTail::kOctaves + o];
        if (gain == 0) continue;
        const std::vector<float>& sum = waves_->sum(o, channel);
        for (std::size_t n = 0; n < low + CarrierInterpolator::kAfter; ++n)
            low_[CarrierInterpolator::kBefore + n] += gain * sum[n];
    }
    // The last samples of the low carriers may end beyond the response.
    out.resize(low * carriers_->decimation());
    interpolator_.process(low_.data(), low, out.data());
    out.resize(samples);
}

// Every channel is first shaped with the energies of W. Then the channels are mixed to the field's
// covariance, with mixing matrices interpolated linearly between the ends of segments.
void ImpulseResponseBuilder::State::build(const EnergyResponse& energy, ImpulseResponse& out,
                                          double crossover_hz, TailScale& scale,
                                          std::size_t samples) {
    out.sample_rate_hz = carriers_->sample_rate_hz();
    out.paths = energy.paths;
    out.channels.resize(channels_.size());

    const std::vector<TailSegment> segments =
        tail_envelope(energy, model_, carriers_->sample_rate_hz());
    begin_room(energy.room);
    measure_carriers(energy.bins, segments);
    // The distance that sound travels in a sample of the low carriers.
    const auto sample_m =
        static_cast<float>(double{energy.speed_of_sound_m_s} *
                           static_cast<double>(carriers_->decimation()) / out.sample_rate_hz);
    const Bands wanted = wanted_energy(energy);
    const Values above = amplitudes_above(crossover_hz);
    const OctaveShares shares_of_octaves = shares(segments, above);
    const Bands wanted_low = wanted * shares_of_octaves.low;
    const Bands wanted_high = wanted * shares_of_octaves.high;
    const bool is_whole = samples >= length_samples_ || !has_scale(scale, wanted_low);
    const std::size_t count = is_whole ? length_samples_ : samples;
    waves_->build(segments, above, energy.listener / sample_m,
                  low_samples(count) + CarrierInterpolator::kAfter);
    std::vector<Values> gain;
    for (std::size_t c = 0; c < channels_.size(); ++c) {
        gain.push_back(gains(channels_[c], segments, wanted_high));
        for (std::size_t k = 0; k < kCarriers; ++k) gain[c][k] *= above[k];
        if (is_whole) set_scale(c, wanted_low, scale);
        out.channels[c].resize(count);
        add_low(c, scale, out.channels[c]);
    }

    std::vector<float> mixing(covariance_.triangle());
    std::vector<float> mixing_end(covariance_.triangle());
    std::vector<float> slope(covariance_.triangle());
    std::vector<float> noises(channels_.size() * kChunk_samples);
    std::size_t filled = 0;
    for (const TailSegment& s : segments) {
        const std::size_t begin = first_sample(s.begin_s);
        const std::size_t end = std::min(first_sample(s.end_s), count);
        if (begin >= end) break;
        filled = end;
        if (&s == &segments.front()) covariance_.mixing(s.directions, mixing.data());
        covariance_.mixing(s.directions_end, mixing_end.data());
        const auto per_sample =
            static_cast<float>(1 / (start_samples(s.end_s) - start_samples(s.begin_s)));
        for (std::size_t i = 0; i < slope.size(); ++i) {
            slope[i] = (mixing_end[i] - mixing[i]) * per_sample;
        }
        for (std::size_t first = begin; first < end; first += kChunk_samples) {
            const std::size_t chunk = std::min(kChunk_samples, end - first);
            const float offset = middle(first, s.begin_s);
            std::array<const float*, 16> noise{};
            for (std::size_t c = 0; c < channels_.size(); ++c) {
                float* const shaped = noises.data() + c * kChunk_samples;
                noise[c] = shaped;
                // Interpolation rings before the first arrival.
                if (s.loudest == 0) {
                    std::fill_n(shaped, chunk, 0.0F);
                    continue;
                }
                std::copy_n(out.channels[c].data() + first, chunk, shaped);
                set_lines(s, channels_[c], gain[c], first);
                best_version<shape>(chunk, offset, lines_, shaped);
            }
            for (std::size_t c = 0; c < channels_.size(); ++c) {
                const std::size_t row = c * (c + 1) / 2;
                best_version<mix>(chunk, offset, c + 1, mixing.data() + row, slope.data() + row,
                                  noise, out.channels[c].data() + first);
            }
        }
        mixing.swap(mixing_end);
    }
    for (auto& channel : out.channels) {
        std::fill(channel.begin() + static_cast<std::ptrdiff_t>(filled), channel.end(), 0.0F);
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

void ImpulseResponseBuilder::build(const EnergyResponse& energy, ImpulseResponse& out,
                                   double crossover_hz, TailScale* scale, std::size_t samples) {
    TailScale unused;
    state_->build(energy, out, crossover_hz, scale ? *scale : unused, samples);
}

std::size_t ImpulseResponseBuilder::length_samples() const { return state_->length_samples_; }

std::size_t ImpulseResponseBuilder::memory_bytes() const {
    const std::vector<Channel>& channels = state_->channels_;
    std::size_t bytes = sizeof(State) + channels.capacity() * sizeof(Channel) +
                        state_->low_.capacity() * sizeof(float) +
                        (state_->waves_ ? state_->waves_->memory_bytes() : 0);
    for (const Channel& c : channels) bytes += c.moments.capacity() * sizeof(Moments);
    return bytes;
}

}  // namespace aula
