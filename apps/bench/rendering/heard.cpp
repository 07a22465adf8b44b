#include "apps/bench/rendering/heard.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>
#include <span>
#include <string>

#include "apps/bench/base/statistics.h"
#include "aula/engine/impulse_response.h"
#include "aula/engine/propagation.h"
#include "aula/engine/room_acoustics.h"
#include "aula/engine/third_octaves.h"
#include "aula/exception.h"
#include "aula/measurement.h"
#include "engine/response/band_pass.h"
#include "engine/response/decay_curve.h"
#include "engine/response/measured_decay.h"

namespace aula::bench {

namespace {

constexpr double kRate_hz = 48000;
constexpr int kOctave500 = -1;  // of FrequencyBand::at
constexpr double kTone_hz = 1000;
constexpr double kHighTone_hz = 1500;  // the highest of the field in space

std::size_t samples_of(double time_s) { return static_cast<std::size_t>(time_s * kRate_hz); }

/// Share of the samples beyond the standard deviation, re that of Gaussian noise, in 20 ms around a
/// time; none if the response is silent there.
std::optional<double> echo_density(std::span<const float> response, double time_s) {
    constexpr double kHalf_s = 0.01;
    const std::size_t begin = samples_of(std::max(time_s - kHalf_s, 0.0));
    const std::size_t end = std::min(samples_of(time_s + kHalf_s), response.size());
    if (begin >= end) return {};
    const auto part = response.subspan(begin, end - begin);
    double energy = 0;
    for (const float x : part) energy += double{x} * double{x};
    const double deviation = std::sqrt(energy / static_cast<double>(part.size()));
    if (!(deviation > 0)) return {};
    const auto beyond = std::count_if(part.begin(), part.end(),
                                      [&](float x) { return std::abs(double{x}) > deviation; });
    return static_cast<double>(beyond) / static_cast<double>(part.size()) /
           std::erfc(1 / std::numbers::sqrt2);
}

/// The part of a tail in which a field has become diffuse and is far above its end.
std::vector<double> late(const std::vector<float>& tail, const FrequencyBand& band) {
    const std::vector<double> filtered = band_passed(tail, kRate_hz, band, 0);
    const auto at = [&](double share) {
        return filtered.begin() +
               static_cast<std::ptrdiff_t>(share * static_cast<double>(tail.size()));
    };
    return {at(0.1), at(0.5)};
}

/// Fourth moment over the squared second one, without the decay: over windows of 50 ms.
std::optional<double> kurtosis(const std::vector<float>& tail, int octave) {
    const std::vector<double> x = late(tail, FrequencyBand::at(octave, 1));
    const std::size_t window = samples_of(0.05);
    double sum = 0;
    int count = 0;
    for (std::size_t first = 0; first + window <= x.size(); first += window) {
        double second = 0;
        double fourth = 0;
        for (std::size_t n = first; n < first + window; ++n) {
            second += x[n] * x[n];
            fourth += x[n] * x[n] * x[n] * x[n];
        }
        if (!(second > 0)) return {};
        sum += fourth * static_cast<double>(window) / (second * second);
        ++count;
    }
    return count > 0 ? std::optional<double>(sum / count) : std::nullopt;
}

/// The correlation of two tails in the octave of 500 Hz.
std::optional<double> correlation(const std::vector<float>& a, const std::vector<float>& b) {
    const std::vector<double> x = late(a, FrequencyBand::at(kOctave500, 1));
    const std::vector<double> y = late(b, FrequencyBand::at(kOctave500, 1));
    double xy = 0, xx = 0, yy = 0;
    for (std::size_t n = 0; n < std::min(x.size(), y.size()); ++n) {
        xy += x[n] * y[n];
        xx += x[n] * x[n];
        yy += y[n] * y[n];
    }
    return xx > 0 && yy > 0 ? std::optional<double>(xy / std::sqrt(xx * yy)) : std::nullopt;
}

/// The level of a tone after its transient.
double tone_db(const std::vector<float>& tail, double frequency_hz) {
    std::complex<double> sum;
    for (std::size_t n = 0; n < tail.size(); ++n)
        sum += double{tail[n]} * std::polar(1.0, -2 * std::numbers::pi * frequency_hz / kRate_hz *
                                                     static_cast<double>(n));
    return 10 * std::log10(std::norm(sum));
}

double mean_of(const std::vector<double>& values) {
    double sum = 0;
    for (const double x : values) sum += x;
    return sum / static_cast<double>(values.size());
}

double deviation(const std::vector<double>& values) {
    const double mean = mean_of(values);
    double square = 0;
    for (const double x : values) square += (x - mean) * (x - mean);
    return std::sqrt(square / static_cast<double>(values.size() - 1));
}

/// The standard deviation of the level over frequency within the octave of 1 kHz.
double spectrum_deviation_db(const std::vector<float>& tail) {
    constexpr int kTones = 60;
    std::vector<double> levels;
    for (int i = 0; i < kTones; ++i)
        levels.push_back(tone_db(tail, kTone_hz * std::exp2((i + 0.5) / kTones - 0.5)));
    return deviation(levels);
}

/// The decays of third octaves of tails of the same energy, with independent noises.
class MeanDecays {
 public:
    explicit MeanDecays(std::size_t length_samples) {
        for (std::size_t t = k250Hz; t < kThirdOctaveCount; ++t) {
            // The filter averages the end of the tail with the silence after it.
            const std::size_t silent = samples_of(1 / band(t).width_hz());
            decays_[t] = {.energy = {}, .bin_s = kBin_s, .tail = {}};
            decays_[t].energy.resize((length_samples - std::min(silent, length_samples)) /
                                     samples_of(kBin_s));
        }
    }

    void add(const std::vector<float>& tail) {
        ++count_;
        for (std::size_t t = k250Hz; t < kThirdOctaveCount; ++t) {
            const std::vector<double> filtered = band_passed(tail, kRate_hz, band(t), 0);
            std::vector<double>& energy = decays_[t].energy;
            for (std::size_t n = 0; n < energy.size() * samples_of(kBin_s); ++n)
                energy[n / samples_of(kBin_s)] += filtered[n] * filtered[n];
        }
    }

    /// The largest error of T20, where it is, and the standard deviation there by the noises (ISO
    /// 3382-2, A.1).
    void report(const ThirdOctaveParameters& wanted, Row& row) const {
        std::optional<double> largest;
        std::optional<double> deviation;
        std::string where;
        for (std::size_t t = k250Hz; t < kThirdOctaveCount; ++t) {
            const auto t20_s = band_parameters(DecayCurve(decays_[t])).t20_s;
            if (!t20_s || !wanted[t].t20_s) continue;
            const double error = 100 * (*t20_s / *wanted[t].t20_s - 1);
            if (largest && std::abs(*largest) >= std::abs(error)) continue;
            largest = error;
            deviation = 88 / std::sqrt(band(t).width_hz() * *t20_s * count_);
            where = third_octave_name(t);
        }
        row.figures.emplace_back("t20_error_percent", largest ? Value(*largest) : Value());
        row.figures.emplace_back("t20_deviation_percent", deviation ? Value(*deviation) : Value());
        row.figures.emplace_back("t20_error_hz", largest ? Value(where) : Value());
    }

 private:
    static constexpr std::size_t k250Hz = 7;
    static constexpr double kBin_s = 1e-3;

    static FrequencyBand band(std::size_t third) {
        return FrequencyBand::at(static_cast<int>(third) - 13, 3);
    }

    std::array<SampledDecay, kThirdOctaveCount> decays_;
    int count_ = 0;
};

/// T20 of a single tail varies by 12 % in the third octave of 250 Hz if it is 0.9 s, and its mean
/// over tails is 3 % longer than that of their mean decay. With as many it varies by 1.2 %.
constexpr int kNoises = 100;

/// Places within half a metre, more than half a wavelength of the tone apart.
std::vector<Vec3> places_around() {
    constexpr float kApart_m = 0.25F;
    std::vector<Vec3> places;
    for (int i = 0; i < 48; ++i)
        places.push_back(kApart_m * Vec3(static_cast<float>(i % 4) - 1.5F,
                                         static_cast<float>(i / 4 % 4) - 1.5F,
                                         static_cast<float>(i / 16) - 1.0F));
    return places;
}

Value value(const std::optional<double>& number) { return number ? Value(*number) : Value(); }

}  // namespace

std::vector<Row> measure_heard(const Subject& subject, const Settings& settings) {
    const Scene& scene = subject.scene;
    settings.progress("heard: impulse response");
    const auto measured = measure(scene, {.frames = subject.frames, .parameters = false});
    const EnergyResponse& energy = measured->response(0);
    const std::vector<float> whole =
        ImpulseResponses(*measured, {.output = OutputFormat::mono}).response(0)[0];
    ImpulseResponseBuilder builder(make_noise_carriers(kRate_hz, scene.simulation.seed),
                                   scene.medium, measured->length_s, scene.sources[0].name, 0);
    ImpulseResponse response;
    builder.build(energy, response);
    const std::vector<float> tail = response.channels[0];
    if (std::all_of(whole.begin(), whole.end(), [](float x) { return x == 0; }))
        throw InputError(subject.name + ": its first source is not audible at the listener");

    Row row;
    row.figures = {{"bench", "heard"}, {"scene", subject.name}};
    const double zero_s = static_cast<double>(first_arrival(whole)) / kRate_hz;
    for (const int ms : {5, 20, 50, 100})
        row.figures.emplace_back("density_" + std::to_string(ms),
                                 value(echo_density(whole, zero_s + ms / 1000.0)));
    row.figures.emplace_back("kurtosis_250", value(kurtosis(tail, -2)));
    row.figures.emplace_back("kurtosis_1000", value(kurtosis(tail, 0)));
    row.figures.emplace_back("kurtosis_4000", value(kurtosis(tail, 2)));
    row.figures.emplace_back("spectrum_db", spectrum_deviation_db(tail));

    settings.progress("heard: decays");
    EnergyResponse without_paths = energy;
    without_paths.paths.clear();
    MeanDecays decays(builder.length_samples());
    for (int i = 0; i < kNoises; ++i) {
        ImpulseResponseBuilder(make_noise_carriers(kRate_hz, scene.simulation.seed), scene.medium,
                               measured->length_s, std::to_string(i), 0)
            .build(without_paths, response);
        decays.add(response.channels[0]);
    }
    decays.report(third_octave_parameters(without_paths, scene.medium), row);

    settings.progress("heard: other places");
    Propagation propagation(scene, scene.simulation);
    FrameInput input{0, {scene.sources[0].position_at(0)}, {scene.listener.pose_at(0).position}};
    for (int frame = 0; frame < subject.frames; ++frame) propagation.step(input);
    // None where the source is not audible, as outside the room.
    const auto tail_at = [&](const Vec3& from_listener_m) -> std::optional<std::vector<float>> {
        input.listeners[0] = scene.listener.pose_at(0).position + from_listener_m;
        propagation.step(input);
        if (!is_audible(propagation.response(0))) return {};
        builder.build(propagation.response(0), response);
        return response.channels[0];
    };
    for (const int mm : {100, 1000}) {
        const float m = static_cast<float>(mm) / 1000;
        std::optional<double> found;
        for (const Vec3& to : {Vec3(m, 0, 0), Vec3(-m, 0, 0), Vec3(0, m, 0), Vec3(0, -m, 0)}) {
            const auto there = found ? std::nullopt : tail_at(to);
            if (there) found = correlation(tail, *there);
        }
        row.figures.emplace_back("correlation_" + std::to_string(mm), value(found));
    }
    std::vector<double> levels;
    std::vector<double> high_levels;
    for (const Vec3& place : places_around()) {
        const auto there = tail_at(place);
        if (!there) continue;
        levels.push_back(tone_db(*there, kTone_hz));
        high_levels.push_back(tone_db(*there, kHighTone_hz));
    }
    const auto varies = [](const std::vector<double>& of) {
        return of.size() > 2 ? Value(deviation(of)) : Value();
    };
    row.figures.emplace_back("tone_db", varies(levels));
    row.figures.emplace_back("tone_1500_db", varies(high_levels));
    return {row};
}

const std::vector<Column>& heard_columns() {
    static const std::vector<Column> columns{{"scene", "scene", 0},
                                             {"density_5", "density 5 ms", 2},
                                             {"density_20", "20 ms", 2},
                                             {"density_50", "50 ms", 2},
                                             {"density_100", "100 ms", 2},
                                             {"kurtosis_250", "kurtosis 250 Hz", 2},
                                             {"kurtosis_1000", "1 kHz", 2},
                                             {"kurtosis_4000", "4 kHz", 2},
                                             {"spectrum_db", "spectrum dB", 2},
                                             {"t20_error_percent", "T20 error %", 1},
                                             {"t20_deviation_percent", "+-", 1},
                                             {"t20_error_hz", "at Hz", 0},
                                             {"correlation_100", "correlation 0.1 m", 2},
                                             {"correlation_1000", "1 m", 2},
                                             {"tone_db", "tone dB", 2},
                                             {"tone_1500_db", "1.5 kHz", 2}};
    return columns;
}

}  // namespace aula::bench
