#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace aula {

/// A mono sound in memory.
struct SoundClip {
    double sample_rate_hz = 48000;
    std::vector<float> samples;
    std::vector<std::string> warnings;  ///< such as "voice.wav: 2 channels mixed down to one"
};

/// Reads a WAV (also RF64, W64), AIFF, AU, CAF, FLAC, Ogg, MP3 or NIST SPHERE file, mixes it down
/// to mono and resamples it. Samples that are not finite or exceed 2^31 in magnitude become 0 with
/// a warning. Throws InputError, also for another format, sample rates outside 1 to 768 kHz,
/// more than 64 channels, or more than 2^28 samples before or after resampling.
SoundClip read_sound(const std::filesystem::path& file, double sample_rate_hz);

struct SoundInfo {
    std::int64_t frames = 0;  ///< length, sample frames
    double sample_rate_hz = 0;
    int channels = 0;
};

/// Reads the header of a sound file. Throws InputError.
SoundInfo sound_info(const std::filesystem::path& file);

enum class SampleFormat { float32, pcm24, pcm16 };

/// Writes a WAV file under a temporary name in its folder and renames it in commit(). Without
/// commit() the file is removed. Throws InputError if the folder is not writable, Failure
/// if writing fails (disk full).
class WavWriter {
 public:
    WavWriter(const std::filesystem::path& file, double sample_rate_hz, std::size_t channels,
              SampleFormat format);
    ~WavWriter();

    /// Appends interleaved samples, [sample][channel]. Samples that are not finite are written as
    /// silence.
    void write(std::span<const float> interleaved);

    /// Number of samples that were not finite, all channels.
    std::int64_t muted_samples() const;

    /// Completes the file under its name.

    void commit();

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
