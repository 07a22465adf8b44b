#include "apps/session/offline/interaural.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "audio/spatial/hrtf.h"
#include "aula/engine/impulse_response.h"
#include "engine/base/worker_pool.h"
#include "engine/response/octave_bank.h"
#include "engine/response/time_zero.h"

namespace aula {

namespace {

constexpr double kEarly_s = 0.08;
constexpr double kLongestDelay_s = 0.001;
constexpr double kFilterDecay_s = 0.3;  // of the octave filters
constexpr double kSampleRate_hz = 48000;
constexpr int kNoises = 4;

using BandSignals = std::array<std::vector<double>, kBandCount>;

/// The octave bands of a signal, longer by the decay of the filters.
BandSignals octaves_of(std::span<const float> signal, double sample_rate_hz) {
    std::vector<double> padded(signal.begin(), signal.end());
    padded.resize(signal.size() + static_cast<std::size_t>(kFilterDecay_s * sample_rate_hz));
    const auto samples = OctaveBank(sample_rate_hz).process(padded);
    BandSignals bands;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        bands[b].reserve(samples.size());
        for (const auto& sample : samples) bands[b].push_back(sample[b]);
    }
    return bands;
}

std::optional<double> coefficient(const std::vector<double>& left, const std::vector<double>& right,
                                  double sample_rate_hz) {
    double left_energy = 0;
    double right_energy = 0;
    for (const double x : left) left_energy += x * x;
    for (const double x : right) right_energy += x * x;
    if (!(left_energy > 0 && right_energy > 0)) return std::nullopt;
    const auto longest = static_cast<std::ptrdiff_t>(kLongestDelay_s * sample_rate_hz);
    const auto count = static_cast<std::ptrdiff_t>(left.size());
    double largest = 0;
    for (std::ptrdiff_t delay = -longest; delay <= longest; ++delay) {
        const std::ptrdiff_t begin = std::max<std::ptrdiff_t>(0, -delay);
        const std::ptrdiff_t end = std::min(count, count - delay);
        double sum = 0;
        for (std::ptrdiff_t n = begin; n < end; ++n)
            sum += left[static_cast<std::size_t>(n)] * right[static_cast<std::size_t>(n + delay)];
        largest = std::max(largest, std::abs(sum));
    }
    return std::min(1.0, largest / std::sqrt(left_energy * right_energy));
}

/// The receiver turned to a source, unless that is above or below it.
Pose facing(const Pose& receiver, const Vec3& source) {
    constexpr float kAbove = 1e-3F;  // of the height
    const Vec3 to_source = source - receiver.position;
    if (std::hypot(to_source.x, to_source.y) <= kAbove * std::abs(to_source.z)) return receiver;
    return {.position = receiver.position, .yaw_rad = std::atan2(to_source.y, to_source.x)};
}

/// A pair as a separate measurement, with its noise chosen by a number.
Measurement alone(const Measurement& measurement, std::size_t pair, int noise) {
    const std::size_t receivers = measurement.receivers.size();
    Measurement one;
    one.sources = {measurement.sources[pair / receivers]};
    one.receivers = {
        facing(measurement.receivers[pair % receivers], one.sources[0].position_at(0))};
    one.sources[0].name.append("/").append(std::to_string(noise));
    one.simulation = measurement.simulation;
    one.responses = {measurement.responses[pair]};
    one.audible = {1};
    one.length_s = measurement.length_s;
    return one;
}

/// Mean and standard error of values that all exist, else empty.
MeasuredValue mean_of(std::span<const std::optional<double>> values) {
    const auto count = static_cast<double>(values.size());
    double sum = 0;
    double squares = 0;
    for (const std::optional<double>& value : values) {
        if (!value) return {};
        sum += *value;
    }
    for (const std::optional<double>& value : values) squares += std::pow(*value - sum / count, 2);
    return {sum / count, std::sqrt(squares / (count - 1) / count)};
}

/// The mean of the octaves of 500, 1000 and 2000 Hz, with the error of their mean.
MeasuredValue single_number(std::span<const MeasuredValue> bands) {
    MeasuredValue mean{0.0, 0.0};
    double squares = 0;
    for (const MeasuredValue& band : bands.subspan(3, 3)) {
        if (!band.value) return {};
        *mean.value += *band.value / 3;
        squares += std::pow(*band.standard_error / 3, 2);
    }
    mean.standard_error = std::sqrt(squares);
    return mean;
}

void add(PairParameters& parameters, const Measurement& measurement, std::size_t pair,
         const std::shared_ptr<const Hrtf>& hrtf) {
    const double zero_s = time_zero_s(measurement.responses[pair]);
    std::array<std::array<std::optional<double>, kNoises>, kBandCount> early;
    std::array<std::array<std::optional<double>, kNoises>, kBandCount> late;
    for (int noise = 0; noise < kNoises; ++noise) {
        const Measurement one = alone(measurement, pair, noise);
        const auto ears =
            ImpulseResponses(
                one, {.sample_rate_hz = kSampleRate_hz, .output = OutputFormat::binaural}, hrtf)
                .response(0);
        const auto bands = interaural_parameters(ears[0], ears[1], kSampleRate_hz, zero_s);
        for (std::size_t b = 0; b < kBandCount; ++b) {
            early[b][static_cast<std::size_t>(noise)] = bands[b].early;
            late[b][static_cast<std::size_t>(noise)] = bands[b].late;
        }
    }
    const auto set = [&](AcousticParameter parameter, const auto& values) {
        const auto p = static_cast<std::size_t>(parameter);
        for (std::size_t b = 0; b < kBandCount; ++b) {
            // As all others, these parameters need the whole response.
            if (parameters.octave(AcousticParameter::g, b).value)
                parameters.octaves[p][b] = mean_of(values[b]);
        }
        parameters.broadband[p] = single_number(parameters.octaves[p]);
    };
    set(AcousticParameter::iacc_early, early);
    set(AcousticParameter::iacc_late, late);
}

}  // namespace

std::array<InterauralParameters, kBandCount> interaural_parameters(std::span<const float> left,
                                                                   std::span<const float> right,
                                                                   double sample_rate_hz,
                                                                   double zero_s) {
    // Divided before the filters, whose low octaves would spread sound over the limit.
    const auto limit = std::min(
        left.size(), static_cast<std::size_t>(std::lround((zero_s + kEarly_s) * sample_rate_hz)));
    const auto bands_of = [&](std::span<const float> ear) {
        return std::pair(octaves_of(ear.first(limit), sample_rate_hz),
                         octaves_of(ear.subspan(limit), sample_rate_hz));
    };
    const auto [left_early, left_late] = bands_of(left);
    const auto [right_early, right_late] = bands_of(right);
    std::array<InterauralParameters, kBandCount> bands;
    for (std::size_t b = 0; b < kBandCount; ++b)
        bands[b] = {coefficient(left_early[b], right_early[b], sample_rate_hz),
                    coefficient(left_late[b], right_late[b], sample_rate_hz)};
    return bands;
}

bool add_interaural_parameters(Measurement& measurement,
                               const std::function<bool(double done)>& progress) {
    const auto hrtf = load_hrtf({}, kSampleRate_hz);
    // All impulse responses share these while they exist.
    const auto carriers = make_noise_carriers(kSampleRate_hz, measurement.simulation.seed);
    const int threads = measurement.simulation.threads.value_or(1);
    WorkerPool workers(threads);
    const std::size_t pairs = measurement.parameters.size();
    // A few pairs at a time, so that a stop is seen soon.
    const std::size_t batch = 2 * static_cast<std::size_t>(threads);
    for (std::size_t first = 0; first < pairs; first += batch) {
        workers.run(std::min(batch, pairs - first), [&](std::size_t i) {
            const std::size_t pair = first + i;
            if (measurement.audible[pair])
                add(measurement.parameters[pair], measurement, pair, hrtf);
        });
        const auto done = static_cast<double>(std::min(first + batch, pairs));
        if (progress && !progress(done / static_cast<double>(pairs))) return false;
    }
    return true;
}

}  // namespace aula
