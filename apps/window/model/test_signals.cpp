#include "apps/window/model/test_signals.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace aula {

namespace {

constexpr double kPeriod_s = 1.5;

std::size_t samples_of(double seconds, double sample_rate_hz) {
    return static_cast<std::size_t>(std::lround(seconds * sample_rate_hz));
}

/// White noise, uniform in -peak..peak.
std::vector<float> white(std::size_t count, float peak) {
    std::mt19937 random(1);  // a fixed seed
    std::uniform_real_distribution<float> uniform(-peak, peak);
    std::vector<float> samples(count);
    for (float& sample : samples) sample = uniform(random);
    return samples;
}

Source endless_noise() {
    Source source;
    source.signal = Source::Signal::noise;
    return source;
}

}  // namespace

const char* test_signal_name(TestSignal signal) {
    switch (signal) {
        case TestSignal::clap:
            return "clap";
        case TestSignal::noise_burst:
            return "noise burst";
        case TestSignal::noise:
            return "noise";
        case TestSignal::clicks:
            return "clicks";
    }
    return "";
}

std::shared_ptr<const Signal> test_signal(TestSignal signal, double sample_rate_hz) {
    const std::size_t period = samples_of(kPeriod_s, sample_rate_hz);
    std::vector<float> samples;
    switch (signal) {
        case TestSignal::clap: {
            constexpr double kDecay_s = 0.004;
            samples = white(samples_of(0.04, sample_rate_hz), 0.5F);
            for (std::size_t i = 0; i < samples.size(); ++i)
                samples[i] *= static_cast<float>(
                    std::exp(-static_cast<double>(i) / (kDecay_s * sample_rate_hz)));
            samples.resize(period);
            break;
        }
        case TestSignal::noise_burst: {
            constexpr double kEdge_s = 0.005;
            samples = white(samples_of(0.25, sample_rate_hz), 0.3F);
            const std::size_t edge = samples_of(kEdge_s, sample_rate_hz);
            for (std::size_t i = 0; i < edge; ++i) {
                const double phase =
                    std::numbers::pi * static_cast<double>(i) / static_cast<double>(edge);
                const auto weight = static_cast<float>(0.5 - 0.5 * std::cos(phase));
                samples[i] *= weight;
                samples[samples.size() - 1 - i] *= weight;
            }
            samples.resize(period);
            break;
        }
        case TestSignal::noise:
            return std::make_shared<const Signal>(endless_noise(), sample_rate_hz, 1);
        case TestSignal::clicks:
            samples.resize(samples_of(0.5, sample_rate_hz));
            samples[0] = 0.5F;
            break;
    }
    return std::make_shared<const Signal>(std::move(samples), true);
}

}  // namespace aula
