#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "audio/base/realtime.h"
#include "audio/device/microphone.h"
#include "engine/scene/scene.h"

namespace aula {

/// What a source plays, before its gain: a function of the sample index alone, so that any block
/// can be asked for in any order and gives the same samples. A file plays from its first sample,
/// an impulse is one unit sample, looped each second; noise is white and uniform with an RMS of
/// -20 dBFS and never ends. A microphone alone plays what it hears now, whatever the index.
class Signal {
 public:
    /// Reads and resamples the file, if it is one. Different `noise_seed`s give independent noise.
    /// Throws AudioInputError.
    Signal(const Source& source, double sample_rate_hz, std::uint64_t noise_seed);

    /// Plays samples that were made elsewhere.
    Signal(std::vector<float> samples, bool loop);

    /// Plays what is heard live.
    explicit Signal(std::shared_ptr<Microphone> microphone);

    /// Samples from index `first` on, to be played from `position` of all that is played on; zero
    /// beyond the end. [audio thread, wait-free]
    void read(std::int64_t first, std::int64_t position,
              std::span<float> out) const noexcept AULA_NONBLOCKING;

    /// Whether its first sample is one among others: noise, and files that are cut in the middle of
    /// a sound. One that starts in silence, or with an onset, is not.
    bool begins_in_mid_wave() const noexcept AULA_NONBLOCKING { return begins_in_mid_wave_; }

    /// Samples of an unlooped file or impulse; empty if it never ends.
    std::optional<std::int64_t> length_samples() const;

    /// Samples of one round of a loop; empty if it is no loop.
    std::optional<std::int64_t> cycle_samples() const;

    /// Such as "voice.wav: 2 channels mixed down to one".
    const std::vector<std::string>& warnings() const { return warnings_; }

 private:
    bool noise_;
    bool loop_;
    std::uint64_t noise_seed_;
    std::shared_ptr<Microphone> microphone_;  ///< may be null
    std::vector<float> samples_;  ///< the file, or one second (looped) or sample of an impulse
    bool begins_in_mid_wave_ = false;
    std::vector<std::string> warnings_;
};

/// One signal for each source of a scene. Shared, so that what is kept is not read again.
using SignalSet = std::vector<std::shared_ptr<const Signal>>;

/// The signal of one source of a scene. Throws AudioInputError.
std::shared_ptr<const Signal> read_signal(const Scene& scene, std::size_t source,
                                          double sample_rate_hz);

/// The signals of all sources, in their order. Throws AudioInputError.
SignalSet read_signals(const Scene& scene, double sample_rate_hz);

/// What was odd about the files of all.
std::vector<std::string> warnings_of(const SignalSet& signals);

}  // namespace aula
