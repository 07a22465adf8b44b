#include "audio/spatial/hrtf.h"

#include <algorithm>
#include <cmath>
#include <compare>
#include <cstdint>
#include <limits>
#include <map>
#include <mutex>
#include <string>
#include <system_error>
#include <utility>

#include "audio/dsp/fft.h"
#include "audio/dsp/resample.h"
#include "audio/spatial/ambisonic_decoder.h"
#include "audio/spatial/ambisonics.h"
#include "audio/spatial/default_head.h"
#include "audio/spatial/direction_set.h"
#include "audio/spatial/head_responses.h"
#include "audio/spatial/response_splitter.h"
#include "audio/spatial/sofa_file.h"
#include "aula/exception.h"

namespace aula {

namespace {

constexpr double kResponse_s = 256.0 / 48000;

// The diffuse-field equalisation is bounded re the mean level in this band: frequencies without
// energy in the measurement cannot be restored.
constexpr double kLevelFrom_hz = 200;
constexpr double kLevelTo_hz = 8000;
constexpr double kGreatestBoost = 16;  // 24 dB

// Silence before the responses, for the resampler's ringing before an early onset.
constexpr std::size_t kLead_samples = 64;

// Limits of plausible measurements; anything else is an error of the file.
constexpr float kLowestRate_hz = 8000;
constexpr float kHighestRate_hz = 768'000;
constexpr double kLongest_s = 0.25;
constexpr float kNearest_m = 1e-3F;
constexpr float kFarthest_m = 1e4F;
constexpr float kQuietestPeak = 1e-6F;
constexpr float kLoudestPeak = 1e6F;
constexpr double kLatestDelay_s = 1;
constexpr double kMaxResampled = 1 << 26;  // 256 MiB

[[noreturn]] void fail(const HeadMeasurements& measured, const std::string& problem) {
    throw InputError(measured.file.string() + ": " + problem);
}

/// Throws InputError unless sizes, rate, positions, responses and delays are plausible.
void check(const HeadMeasurements& measured, double sample_rate_hz) {
    const auto fail = [&](const std::string& problem) { aula::fail(measured, problem); };
    const std::size_t directions = measured.positions.size();
    const std::size_t samples = measured.samples;
    if (directions < 4 || directions > kMaxDirections || samples < 2 ||
        samples > kLongestResponse_samples ||
        measured.responses.size() != 2 * directions * samples ||
        measured.delays_samples.size() != 2 * directions)
        fail("inconsistent sizes; expected two responses for each of 4 directions");
    const float rate_hz = measured.sample_rate_hz;
    if (!(rate_hz >= kLowestRate_hz && rate_hz <= kHighestRate_hz))
        fail("a sample rate of " + std::to_string(rate_hz) + " Hz; expected 8000 to 768000 Hz");
    const auto length = static_cast<double>(samples);
    if (length > kLongest_s * double{rate_hz})
        fail("responses of " + std::to_string(length / double{rate_hz}) +
             " s; expected at most 0.25 s");
    if ((length + 2 * kLead_samples) * 2 * static_cast<double>(directions) * sample_rate_hz >
        kMaxResampled * double{rate_hz})
        fail("too many responses for this sample rate; expected at most 67108864 samples");
    for (std::size_t i = 0; i < directions; ++i) {
        const std::array<float, 3>& p = measured.positions[i];
        const float distance_m = std::hypot(p[0], p[1], p[2]);
        if (!(distance_m >= kNearest_m && distance_m <= kFarthest_m))
            fail("a source " + std::to_string(distance_m) +
                 " m from the head; expected 0.001 to 10000 m");
    }
    for (std::size_t r = 0; r < 2 * directions; ++r) {
        const std::string which =
            "the response of direction " + std::to_string(r / 2) + ", ear " + std::to_string(r % 2);
        const auto response = std::span(measured.responses).subspan(r * samples, samples);
        float peak = 0;
        for (const float x : response) {
            if (!std::isfinite(x)) fail(which + " is not finite; expected numbers");
            peak = std::max(peak, std::abs(x));
        }
        if (!(peak >= kQuietestPeak && peak <= kLoudestPeak))
            fail(which + " has a peak of " + std::to_string(peak) + "; expected 1e-6 to 1e6");
        const float delay_samples = measured.delays_samples[r];
        if (!(std::abs(delay_samples) <= static_cast<float>(kLatestDelay_s) * rate_hz))
            fail(which + " has a delay of " + std::to_string(delay_samples) +
                 " samples; expected at most a second");
    }
}

/// Resampled responses of the directions `kept`, [direction][ear][sample], after kLead_samples of
/// silence.
std::vector<EarPair> resampled(const HeadMeasurements& measured,
                               const std::vector<std::size_t>& kept, double sample_rate_hz) {
    // The resampler needs some 100 kB for each channel of a call.
    constexpr std::size_t kChannelsPerCall = 32;
    const std::size_t channels = 2 * kept.size();
    const std::size_t lead = kLead_samples;
    std::vector<EarPair> out(kept.size());
    for (std::size_t first = 0; first < channels; first += kChannelsPerCall) {
        const std::size_t count = std::min(kChannelsPerCall, channels - first);
        std::vector<float> interleaved((lead + measured.samples + lead) * count);
        for (std::size_t c = 0; c < count; ++c) {
            const std::size_t ear = (first + c) % 2;
            const float* const response =
                measured.responses.data() + (2 * kept[(first + c) / 2] + ear) * measured.samples;
            for (std::size_t n = 0; n < measured.samples; ++n)
                interleaved[(lead + n) * count + c] = response[n];
        }
        interleaved = resample(interleaved, count, double{measured.sample_rate_hz}, sample_rate_hz);
        const std::size_t samples = interleaved.size() / count;
        for (std::size_t c = 0; c < count; ++c) {
            std::vector<float>& channel = out[(first + c) / 2][(first + c) % 2];
            channel.resize(samples);
            for (std::size_t n = 0; n < samples; ++n) channel[n] = interleaved[n * count + c];
        }
    }
    return out;
}

/// Adds the directions that close the gaps of the measured set, and their responses.
void close_gaps(Directions& directions, std::vector<std::array<SplitResponse, 2>>& responses) {
    const auto closing = closing_directions(directions, quadrature_weights(directions));
    for (const ClosingDirection& added : closing) {
        std::array<SplitResponse, 2> ears;
        for (std::size_t e = 0; e < 2; ++e) {
            ears[e].log_magnitude.resize(responses[0][e].log_magnitude.size());
            for (const auto& [index, share] : added.shares) {
                const SplitResponse& from = responses[index][e];
                ears[e].delay_s += share * from.delay_s;
                for (std::size_t k = 0; k < from.log_magnitude.size(); ++k) {
                    ears[e].log_magnitude[k] += static_cast<float>(share) * from.log_magnitude[k];
                }
            }
        }
        directions.push_back(added.direction);
        responses.push_back(std::move(ears));
    }
}

/// Diffuse-field equalisation: logarithm of the gain that makes the mean energy of the ears in a
/// diffuse field 1 at every frequency. It removes the loudspeaker and the ear canal, which are
/// common to all directions.
std::vector<float> diffuse_field_correction(
    const std::vector<std::array<SplitResponse, 2>>& responses, const std::vector<double>& weights,
    double bin_hz) {
    std::vector<double> energy(responses[0][0].log_magnitude.size());
    for (std::size_t i = 0; i < responses.size(); ++i) {
        for (const SplitResponse& ear : responses[i]) {
            for (std::size_t k = 0; k < energy.size(); ++k) {
                energy[k] += 0.5 * weights[i] * std::exp(2 * double{ear.log_magnitude[k]});
            }
        }
    }
    double sum = 0;
    double bins = 0;
    for (std::size_t k = 0; k < energy.size(); ++k) {
        const double frequency_hz = bin_hz * static_cast<double>(k);
        if (frequency_hz < kLevelFrom_hz || frequency_hz > kLevelTo_hz) continue;
        sum += energy[k];
        ++bins;
    }
    std::vector<float> log_gain;
    for (const double e : energy) {
        const double relative = std::max(e / (sum / bins), 1 / (kGreatestBoost * kGreatestBoost));
        log_gain.push_back(static_cast<float>(-0.5 * std::log(relative * sum / bins)));
    }
    return log_gain;
}

/// Identifies the content of a file, and a sample rate.
struct HrtfKey {
    std::filesystem::path file;
    std::filesystem::file_time_type written;
    std::uintmax_t bytes = 0;
    double sample_rate_hz = 0;

    auto operator<=>(const HrtfKey&) const = default;
};

/// An HRTF that is in use; the mutex is locked while it is read.
struct SharedHrtf {
    std::mutex mutex;
    std::weak_ptr<const Hrtf> hrtf;
};

}  // namespace

std::shared_ptr<const Hrtf> load_hrtf(const std::filesystem::path& sofa_file,
                                      double sample_rate_hz) {
    static std::mutex mutex;
    static std::map<HrtfKey, std::shared_ptr<SharedHrtf>> all;
    HrtfKey key;  // without a file: the default
    key.sample_rate_hz = sample_rate_hz;
    if (!sofa_file.empty()) {
        std::error_code missing;
        key.written = std::filesystem::last_write_time(sofa_file, missing);
        key.bytes = missing ? 0 : std::filesystem::file_size(sofa_file, missing);
        if (!missing) key.file = std::filesystem::canonical(sofa_file, missing);
        // The constructor describes the error.
        if (missing) return std::make_shared<const Hrtf>(sofa_file, sample_rate_hz);
    }

    std::unique_lock lock(mutex);
    std::erase_if(all, [](const auto& entry) {
        return entry.second.use_count() == 1 && entry.second->hrtf.expired();
    });
    auto& entry = all[key];
    if (!entry) entry = std::make_shared<SharedHrtf>();
    const std::shared_ptr<SharedHrtf> shared = entry;
    lock.unlock();

    const std::lock_guard reading(shared->mutex);
    auto hrtf = shared->hrtf.lock();
    if (!hrtf) {
        hrtf = std::make_shared<const Hrtf>(sofa_file, sample_rate_hz);
        shared->hrtf = hrtf;
    }
    return hrtf;
}

struct Hrtf::State {
    std::size_t taps = 0;
    HeadResponses head;
    double centre_delay_s = 0;
    float distance_m = 0;
    std::mutex mutex;                          ///< of `decoders`
    std::map<int, AmbisonicDecoder> decoders;  ///< [order] that have been designed
};

Hrtf::Hrtf(const std::filesystem::path& sofa_file, double sample_rate_hz)
    : Hrtf(sofa_file.empty() ? default_head() : read_sofa(sofa_file), sample_rate_hz) {}

Hrtf::Hrtf(const HeadMeasurements& measured, double sample_rate_hz)
    : state_(std::make_unique<State>()) {
    check(measured, sample_rate_hz);
    State& s = *state_;
    s.taps = fast_fft_size(static_cast<std::size_t>(std::llround(kResponse_s * sample_rate_hz)));
    // The responses are those of a far source.
    const std::vector<std::size_t> kept = distinct_directions(measured.positions);
    if (kept.size() < 4)
        fail(measured, std::to_string(kept.size()) + " different directions; expected at least 4");
    const std::vector<EarPair> pairs = resampled(measured, kept, sample_rate_hz);
    ResponseSplitter splitter(pairs[0][0].size(), s.taps, sample_rate_hz);

    HeadResponses& head = s.head;
    head.sample_rate_hz = sample_rate_hz;
    for (const std::size_t i : kept) {
        const std::array<float, 3>& position = measured.positions[i];
        const float length = std::hypot(position[0], position[1], position[2]);
        s.distance_m += length / static_cast<float>(kept.size());
        head.directions.push_back(
            {position[0] / length, position[1] / length, position[2] / length});
    }
    std::vector<std::array<SplitResponse, 2>> responses = splitter.split(pairs);
    for (std::size_t r = 0; r < 2 * kept.size(); ++r) {
        responses[r / 2][r % 2].delay_s +=
            double{measured.delays_samples[2 * kept[r / 2] + r % 2]} /
            double{measured.sample_rate_hz};
    }
    close_gaps(head.directions, responses);
    head.weights = quadrature_weights(head.directions);
    const std::vector<float> correction =
        diffuse_field_correction(responses, head.weights, splitter.bin_hz());
    for (std::array<SplitResponse, 2>& response : responses) {
        std::array<Ear, 2>& ears = head.ears.emplace_back();
        for (std::size_t e = 0; e < 2; ++e) {
            std::vector<float>& log_magnitude = response[e].log_magnitude;
            for (std::size_t k = 0; k < correction.size(); ++k) log_magnitude[k] += correction[k];
            ears[e] = {splitter.minimum_phase(log_magnitude), response[e].delay_s};
        }
    }
    double earliest_s = head.ears[0][0].delay_s;
    double latest_s = earliest_s;
    for (const auto& ears : head.ears) {
        for (const Ear& ear : ears) {
            earliest_s = std::min(earliest_s, ear.delay_s);
            latest_s = std::max(latest_s, ear.delay_s);
            if (!std::all_of(ear.minimum_phase.begin(), ear.minimum_phase.end(),
                             [](float x) { return std::isfinite(x); }))
                fail(measured,
                     "responses without energy below half the sample rate; expected some");
        }
    }
    // The history of the renderer's delay lines is this long.
    if (!(latest_s - earliest_s <= kResponse_s)) {
        fail(measured, "delays that differ by " + std::to_string(latest_s - earliest_s) +
                           " s; expected at most 0.0053 s");
    }
    for (auto& ears : head.ears) {
        for (Ear& ear : ears) ear.delay_s -= earliest_s;
    }
    s.centre_delay_s = head.centre_delay_s();
}

Hrtf::~Hrtf() = default;

float Hrtf::distance_m() const noexcept { return state_->distance_m; }

std::size_t Hrtf::taps() const { return state_->taps; }

const HeadResponses& Hrtf::responses() const { return state_->head; }

const AmbisonicDecoder& Hrtf::decoder(int order) const {
    const std::lock_guard lock(state_->mutex);
    const auto known = state_->decoders.find(order);
    if (known != state_->decoders.end()) return known->second;
    return state_->decoders.emplace(order, design_decoder(state_->head, order)).first->second;
}

std::array<Hrtf::Ear, 2> Hrtf::ears(const std::array<float, 3>& direction) const {
    std::array<Ear, 2> both;
    for (Ear& ear : both) ear.minimum_phase.resize(state_->taps);
    std::array<double, 2> delays_s{};
    ears(direction, {both[0].minimum_phase, both[1].minimum_phase}, delays_s);
    for (std::size_t e = 0; e < 2; ++e) both[e].delay_s = delays_s[e];
    return both;
}

// With a distinctness below 1 the ears of the direction blend linearly to those at the centre of
// the head: the diffuse-field response, which the equalisation makes an impulse, at its delay.
void Hrtf::ears(const std::array<float, 3>& direction,
                const std::array<std::span<float>, 2>& minimum_phase,
                std::array<double, 2>& delays_s) const noexcept {
    const State& s = *state_;
    const HeardDirection heard = heard_direction(direction);
    const float share = heard.distinctness;
    const InterpolationWeights weights = interpolation_weights(s.head.directions, heard.unit);
    for (std::size_t e = 0; e < 2; ++e) {
        delays_s[e] = double{1 - share} * s.centre_delay_s;
        std::fill(minimum_phase[e].begin(), minimum_phase[e].end(), 0.0F);
        minimum_phase[e][0] = 1 - share;
        for (std::size_t k = 0; k < weights.count; ++k) {
            const float weight = share * weights.weight[k];
            const Ear& ear = s.head.ears[weights.index[k]][e];
            delays_s[e] += double{weight} * ear.delay_s;
            const float* const from = ear.minimum_phase.data();
            float* const to = minimum_phase[e].data();
            for (std::size_t n = 0; n < minimum_phase[e].size(); ++n) to[n] += weight * from[n];
        }
    }
}

}  // namespace aula
