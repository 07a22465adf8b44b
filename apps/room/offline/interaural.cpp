#include "apps/room/offline/interaural.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "apps/room/base/output_resources.h"
#include "audio/dsp/fft.h"
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

using Spectrum = std::vector<std::complex<float>>;

Spectrum spectrum_of(RealFft& fft, std::span<const float> signal) {
    std::vector<float> padded(fft.size());
    std::copy(signal.begin(), signal.end(), padded.begin());
    Spectrum spectrum(fft.bins());
    fft.forward(padded.data(), spectrum.data());
    return spectrum;
}

/// The time from which on less than a thousandth of the late energy of each octave arrives. What is
/// cut off there changes a coefficient by less than that.
double relevant_length_s(const EnergyResponse& response, double zero_s, double length_s) {
    constexpr double kRest = 1e-3;
    constexpr double kStep_s = 0.01;
    const std::vector<Bands> steps = response.uniform(kStep_s);
    const auto late = static_cast<std::size_t>((zero_s + kEarly_s) / kStep_s) + 1;
    std::array<double, kBandCount> wanted{};
    for (std::size_t i = late; i < steps.size(); ++i)
        for (std::size_t b = 0; b < kBandCount; ++b) wanted[b] += kRest * double{steps[i][b]};
    std::array<double, kBandCount> rest{};
    for (std::size_t i = steps.size(); i-- > late;)
        for (std::size_t b = 0; b < kBandCount; ++b) {
            rest[b] += double{steps[i][b]};
            if (rest[b] > wanted[b])
                return std::min(length_s, static_cast<double>(i + 1) * kStep_s);
        }
    return std::min(length_s, static_cast<double>(late) * kStep_s);
}

/// The receiver turned to a source, unless that is above or below it.
Pose facing(const Pose& receiver, const Vec3& source) {
    constexpr float kAbove = 1e-3F;  // of the height
    const Vec3 to_source = source - receiver.position;
    if (std::hypot(to_source.x, to_source.y) <= kAbove * std::abs(to_source.z)) return receiver;
    return {.position = receiver.position,
            .yaw_rad = static_cast<float>(std::atan2(double{to_source.y}, double{to_source.x}))};
}

/// A pair as a separate measurement, as long as its coefficients need.
Measurement alone(const Measurement& measurement, std::size_t pair, double zero_s) {
    const std::size_t receivers = measurement.receivers.size();
    Measurement one;
    one.sources = {measurement.sources[pair / receivers]};
    one.receivers = {
        facing(measurement.receivers[pair % receivers], one.sources[0].position_at(0))};
    one.simulation = measurement.simulation;
    one.medium = measurement.medium;
    one.responses = {measurement.responses[pair]};
    one.audible = {1};
    one.length_s = relevant_length_s(one.responses[0], zero_s, measurement.length_s);
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

using Ears = std::vector<std::vector<float>>;

/// MIT KEMAR.
OutputOptions head() {
    return {.sample_rate_hz = kSampleRate_hz, .output = OutputFormat::binaural};
}

Ears binaural(const Measurement& one) { return ImpulseResponses(one, head()).response(0); }

/// The discrete paths of a separate pair. They do not depend on the noise, and end early.
Ears binaural_paths(Measurement one) {
    constexpr double kFilterTail_s = 0.05;
    EnergyResponse& response = one.responses[0];
    response.clear_bins();
    std::erase_if(response.paths, [&](const SoundPath& path) {
        return path.order > 0 && response.arrival_s(path) >= one.length_s;
    });
    if (response.paths.empty()) return {{}, {}};
    one.length_s =
        std::min(one.length_s, response.arrival_s(response.paths.back()) + kFilterTail_s);
    return binaural(one);
}

void add_samples(std::vector<float>& sum, const std::vector<float>& samples) {
    sum.resize(std::max(sum.size(), samples.size()));
    for (std::size_t n = 0; n < samples.size(); ++n) sum[n] += samples[n];
}

void add(PairParameters& parameters, const Measurement& measurement, std::size_t pair,
         const InterauralAnalysis& analysis) {
    const double zero_s = time_zero_s(measurement.responses[pair]);
    std::array<std::array<std::optional<double>, kNoises>, kBandCount> early;
    std::array<std::array<std::optional<double>, kNoises>, kBandCount> late;
    Measurement one = alone(measurement, pair, zero_s);
    const Ears paths = binaural_paths(one);
    one.responses[0].paths.clear();
    const std::string name = one.sources[0].name;
    for (int noise = 0; noise < kNoises; ++noise) {
        // The name chooses the noise.
        one.sources[0].name = name + "/" + std::to_string(noise);
        Ears ears = binaural(one);
        for (std::size_t ear = 0; ear < 2; ++ear) add_samples(ears[ear], paths[ear]);
        const auto bands = analysis.parameters(ears[0], ears[1], zero_s);
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

InterauralAnalysis::InterauralAnalysis(double sample_rate_hz)
    : sample_rate_hz_(sample_rate_hz),
      filter_samples_(static_cast<std::size_t>(kFilterDecay_s * sample_rate_hz)),
      delay_samples_(static_cast<std::size_t>(kLongestDelay_s * sample_rate_hz)),
      // Lags of both signs, and the filters' autocorrelation, which must not reach round to them.
      correlation_size_(fast_fft_size(3 * filter_samples_ + 4 * delay_samples_)) {
    std::vector<double> impulse(filter_samples_);
    impulse[0] = 1;
    const auto filters = OctaveBank(sample_rate_hz).process(impulse);
    RealFft fft(correlation_size_);
    for (std::size_t b = 0; b < kBandCount; ++b) {
        std::vector<float> filter;
        for (const auto& sample : filters) filter.push_back(static_cast<float>(sample[b]));
        for (const std::complex<float>& bin : spectrum_of(fft, filter))
            power_[b].push_back(std::norm(bin));
    }
}

/// An octave of a correlation is the correlation, filtered by the octave's power response. Only the
/// lags within the length of the filters affect those within the longest delay.
InterauralAnalysis::Coefficients InterauralAnalysis::coefficients(
    std::span<const float> left, std::span<const float> right) const {
    const std::size_t lags = filter_samples_ + delay_samples_;
    RealFft fft(fast_fft_size(std::max(left.size() + lags, 2 * lags + 1)));
    const Spectrum of_left = spectrum_of(fft, left);
    const Spectrum of_right = spectrum_of(fft, right);
    RealFft short_fft(correlation_size_);
    /// The spectrum of the correlation of two spectra within `lags`.
    const auto correlated = [&](const Spectrum& a, const Spectrum& b) {
        Spectrum product(a.size());
        for (std::size_t k = 0; k < a.size(); ++k) product[k] = std::conj(a[k]) * b[k];
        std::vector<float> all(fft.size());
        fft.inverse(product.data(), all.data());
        std::vector<float> near(short_fft.size());
        for (std::size_t lag = 0; lag <= lags; ++lag) near[lag] = all[lag];
        for (std::size_t lag = 1; lag <= lags; ++lag)
            near[near.size() - lag] = all[all.size() - lag];
        return spectrum_of(short_fft, near);
    };
    const Spectrum both = correlated(of_left, of_right);
    const Spectrum left_alone = correlated(of_left, of_left);
    const Spectrum right_alone = correlated(of_right, of_right);
    /// An octave of a correlation by lag, those below 0 at the end.
    const auto octave_of = [&](const Spectrum& correlation, std::size_t band) {
        Spectrum filtered(correlation.size());
        for (std::size_t k = 0; k < filtered.size(); ++k)
            filtered[k] = power_[band][k] * correlation[k];
        std::vector<float> octave(short_fft.size());
        short_fft.inverse(filtered.data(), octave.data());
        return octave;
    };
    Coefficients of_bands;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const double energies =
            double{octave_of(left_alone, b)[0]} * double{octave_of(right_alone, b)[0]};
        if (!(energies > 0)) continue;
        const std::vector<float> octave = octave_of(both, b);
        float largest = std::abs(octave[0]);
        for (std::size_t delay = 1; delay <= delay_samples_; ++delay)
            largest = std::max(
                {largest, std::abs(octave[delay]), std::abs(octave[octave.size() - delay])});
        of_bands[b] = std::min(1.0, double{largest} / std::sqrt(energies));
    }
    return of_bands;
}

std::array<InterauralParameters, kBandCount> InterauralAnalysis::parameters(
    std::span<const float> left, std::span<const float> right, double zero_s) const {
    // Divided before the filters, whose low octaves would spread sound over the limit.
    const auto limit = std::min(
        left.size(), static_cast<std::size_t>(std::lround((zero_s + kEarly_s) * sample_rate_hz_)));
    const Coefficients early = coefficients(left.first(limit), right.first(limit));
    const Coefficients late = coefficients(left.subspan(limit), right.subspan(limit));
    std::array<InterauralParameters, kBandCount> bands;
    for (std::size_t b = 0; b < kBandCount; ++b) bands[b] = {early[b], late[b]};
    return bands;
}

double interaural_work_s(std::size_t pairs, double length_s) {
    // Ten further pairs of a lecture hall take 1.8 s of one processor with --ir-length 1, 2.8 s
    // with 2, and no more with longer ones, of which only the relevant part counts.
    constexpr double kPair_s = 0.08;
    constexpr double kSecond_s = 0.1;
    constexpr double kLongest_s = 2;
    return static_cast<double>(pairs) * (kPair_s + kSecond_s * std::min(length_s, kLongest_s));
}

bool add_interaural_parameters(Measurement& measurement,
                               const std::function<bool(double done)>& progress) {
    const InterauralAnalysis analysis(kSampleRate_hz);
    // All impulse responses share these while they exist.
    const auto hrtf = hrtf_for(head());
    const auto carriers = make_noise_carriers(kSampleRate_hz, measurement.simulation.seed);
    const int threads = measurement.simulation.threads.value_or(default_threads());
    WorkerPool workers(threads);
    const std::size_t pairs = measurement.parameters.size();
    // A few pairs at a time, so that a stop is seen soon.
    const std::size_t batch = 2 * static_cast<std::size_t>(threads);
    for (std::size_t first = 0; first < pairs; first += batch) {
        workers.run(std::min(batch, pairs - first), [&](std::size_t i) {
            const std::size_t pair = first + i;
            if (measurement.audible[pair])
                add(measurement.parameters[pair], measurement, pair, analysis);
        });
        const auto done = static_cast<double>(std::min(first + batch, pairs));
        if (progress && !progress(done / static_cast<double>(pairs))) return false;
    }
    return true;
}

}  // namespace aula
