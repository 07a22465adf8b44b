#include "apps/room/frames/signals.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <system_error>
#include <utility>

#include "audio/base/assume_nonblocking.h"
#include "aula/audio/sound_file.h"
#include "aula/exception.h"
#include "engine/base/sampling.h"
#include "engine/mesh/mesh_import.h"

namespace aula {

namespace {

// A uniform distribution over -a..a has the RMS a / sqrt(3); -20 dBFS is an RMS of 0.1.
const float kNoiseAmplitude = 0.1F * std::sqrt(3.0F);

float noise_sample(std::uint64_t seed, std::int64_t index) noexcept AULA_NONBLOCKING {
    const auto bits =
        static_cast<std::int64_t>(RandomStream(seed + static_cast<std::uint64_t>(index)).bits());
    return kNoiseAmplitude * static_cast<float>(static_cast<double>(bits) * 0x1p-63);
}

/// A signal starts abruptly unless its first sample is below -40 dB of the following level
/// (silence) or more than 6 dB above it (an onset).
bool starts_abruptly(const std::vector<float>& samples, bool loop) {
    constexpr std::size_t kBeginning = 512;
    if (samples.empty()) return false;
    double energy = 0;
    for (std::size_t i = 0; i < kBeginning; ++i) {
        if (i >= samples.size() && !loop) break;
        energy += std::pow(static_cast<double>(samples[i % samples.size()]), 2);
    }
    const double level = std::sqrt(energy / kBeginning);
    const double first = std::abs(static_cast<double>(samples[0]));
    return first > 0.01 * level && first < 2 * level;
}

}  // namespace

Signal::Signal(const Source& source, double sample_rate_hz, std::uint64_t noise_seed)
    : noise_(source.signal == Source::Signal::noise),
      loop_(source.loop),
      noise_seed_(derive_seed(noise_seed, 0)) {
    if (source.signal == Source::Signal::impulse) {
        samples_.assign(loop_ ? static_cast<std::size_t>(std::lround(sample_rate_hz)) : 1, 0.0F);
        samples_[0] = 1;
    } else if (source.signal == Source::Signal::file) {
        const auto inside = SoundInModel::of_name(source.signal_file);
        SoundClip clip = inside ? read_sound(inside->read(), source.signal_file, sample_rate_hz)
                                : read_sound(source.signal_file, sample_rate_hz);
        if (clip.samples.empty())
            throw InputError(source.signal_file.string() + ": no samples; expected a sound");
        samples_ = std::move(clip.samples);
        warnings_ = std::move(clip.warnings);
    }
    begins_abruptly_ = noise_ || starts_abruptly(samples_, loop_);
}

Signal::Signal(std::vector<float> samples, bool loop)
    : noise_(false),
      loop_(loop),
      noise_seed_(0),
      samples_(std::move(samples)),
      begins_abruptly_(starts_abruptly(samples_, loop_)) {}

Signal::Signal(LiveInput input)
    : noise_(false), loop_(false), noise_seed_(0), live_input_(std::move(input)) {}

void Signal::read(std::int64_t first, std::int64_t position, std::span<float> out) const noexcept {
    // A LiveInput is wait-free.
    if (live_input_) return assume_nonblocking([&] { live_input_(position, out); });
    if (noise_) {
        for (std::size_t i = 0; i < out.size(); ++i)
            out[i] = noise_sample(noise_seed_, first + static_cast<std::int64_t>(i));
        return;
    }
    const auto length = static_cast<std::int64_t>(samples_.size());
    std::int64_t at = loop_ ? first % length : first;
    for (float& sample : out) {
        if (loop_ && at == length) at = 0;
        sample = at < length ? samples_[static_cast<std::size_t>(at)] : 0.0F;
        ++at;
    }
}

std::optional<std::int64_t> Signal::length_samples() const {
    if (noise_ || loop_ || live_input_) return std::nullopt;
    return static_cast<std::int64_t>(samples_.size());
}

std::optional<std::int64_t> Signal::cycle_samples() const {
    if (noise_ || !loop_) return std::nullopt;
    return static_cast<std::int64_t>(samples_.size());
}

std::shared_ptr<const Signal> read_signal(const Scene& scene, std::size_t source,
                                          double sample_rate_hz) {
    return std::make_shared<const Signal>(scene.sources[source], sample_rate_hz,
                                          derive_seed(scene.simulation.seed, source));
}

std::shared_ptr<const Signal> SharedSignals::read(std::size_t index) {
    const Source& source = scene_.sources[index];
    if (source.signal != Source::Signal::file) return read_signal(scene_, index, sample_rate_hz_);
    const auto inside = SoundInModel::of_name(source.signal_file);
    std::error_code missing;
    std::filesystem::path name =
        std::filesystem::canonical(inside ? inside->model : source.signal_file, missing);
    if (missing) return read_signal(scene_, index, sample_rate_hz_);  // throws the reason
    if (inside) name = SoundInModel{std::move(name), inside->number}.name();
    std::shared_ptr<const Signal>& file = files_[{name, source.loop}];
    if (!file) file = read_signal(scene_, index, sample_rate_hz_);
    return file;
}

SignalSet read_signals(const Scene& scene, double sample_rate_hz) {
    SharedSignals files(scene, sample_rate_hz);
    SignalSet signals;
    for (std::size_t s = 0; s < scene.sources.size(); ++s) signals.push_back(files.read(s));
    return signals;
}

std::vector<std::string> warnings_of(const SignalSet& signals) {
    std::vector<std::string> all;
    for (const auto& signal : signals) {
        for (const std::string& warning : signal->warnings())
            if (std::find(all.begin(), all.end(), warning) == all.end()) all.push_back(warning);
    }
    return all;
}

}  // namespace aula
