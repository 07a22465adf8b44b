#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "aula/audio/realtime.h"
#include "aula/engine/scene.h"

namespace aula {

/// Fills `out` with the samples of a live input, for playback at sample `position` of the output.
/// [audio thread, wait-free]
using LiveInput = std::function<void(std::int64_t position, std::span<float> out)>;

/// The signal of a source, before its gain: a function of the sample index alone, so that blocks
/// can be read in any order. A file plays from its first sample. An impulse is one unit sample,
/// repeated every second if looped. Noise is white and uniform with an RMS of -20 dBFS and never
/// ends. The exception is a live input, such as a microphone, which plays its present samples.
class Signal {
 public:
    /// Reads and resamples a file signal. Different values of `noise_seed` give independent noise.
    /// Throws InputError.
    Signal(const Source& source, double sample_rate_hz, std::uint64_t noise_seed);

    /// Plays given samples.
    Signal(std::vector<float> samples, bool loop);

    /// Plays live input.
    explicit Signal(LiveInput input);

    /// Reads the samples from index `first` on, for playback at `position` of the output; zero
    /// beyond the end. [audio thread, wait-free]
    void read(std::int64_t first, std::int64_t position,
              std::span<float> out) const noexcept AULA_NONBLOCKING;

    /// Whether its first sample is within a sound: noise, and files that start in the middle of a
    /// sound. False for a signal that starts with silence or with an onset.
    bool begins_abruptly() const noexcept AULA_NONBLOCKING { return begins_abruptly_; }

    /// Samples of an unlooped file or impulse; empty if the signal never ends.
    std::optional<std::int64_t> length_samples() const;

    /// Samples of one period of a loop; empty if the signal is not looped.
    std::optional<std::int64_t> cycle_samples() const;

    /// For instance "voice.wav: 2 channels mixed down to one".
    const std::vector<std::string>& warnings() const { return warnings_; }

 private:
    bool noise_;
    bool loop_;
    std::uint64_t noise_seed_;
    LiveInput live_input_;        ///< may be empty
    std::vector<float> samples_;  ///< a file, or an impulse: one second (looped) or one sample
    bool begins_abruptly_ = false;
    std::vector<std::string> warnings_;
};

/// One signal for each source of a scene. Shared, so that unchanged signals are not read again.
using SignalSet = std::vector<std::shared_ptr<const Signal>>;

/// The signal of one source of a scene. Throws InputError.
std::shared_ptr<const Signal> read_signal(const Scene& scene, std::size_t source,
                                          double sample_rate_hz);

/// Reads the signals of a scene's sources. Sources that play the same file, or the same
/// sound inside a model, share its samples.
class SharedSignals {
 public:
    /// The scene must outlive the object.
    SharedSignals(const Scene& scene, double sample_rate_hz)
        : scene_(scene), sample_rate_hz_(sample_rate_hz) {}

    /// The signal of the source with that index. Throws InputError.
    std::shared_ptr<const Signal> read(std::size_t index);

 private:
    using File = std::pair<std::filesystem::path, bool>;  ///< canonical name; whether it is looped

    const Scene& scene_;
    double sample_rate_hz_;
    std::map<File, std::shared_ptr<const Signal>> files_;
};

/// The signals of all sources, in their order, read by SharedSignals. Throws InputError.
SignalSet read_signals(const Scene& scene, double sample_rate_hz);

/// The warnings of all signals, each once.
std::vector<std::string> warnings_of(const SignalSet& signals);

}  // namespace aula
