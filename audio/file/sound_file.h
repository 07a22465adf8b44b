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
/// and resamples it (soxr). Samples that are not finite, or beyond 2^31, become 0 with a warning.
/// Throws AudioInputError, also for another format, a sample rate outside 1 to 768 kHz, more than
/// 64 channels and more than 2^28 samples (before or after resampling).
SoundClip read_sound(const std::filesystem::path& file, double sample_rate_hz);

/// The number of frames and the sample rate without reading the samples. Throws AudioInputError.
struct SoundInfo {
    std::int64_t frames = 0;
    double sample_rate_hz = 0;
    int channels = 0;
};
SoundInfo sound_info(const std::filesystem::path& file);

enum class SampleFormat { float32, pcm24, pcm16 };

/// Writes a WAV file under a temporary name beside it and renames it in commit(); without commit()
/// nothing is left behind. Throws AudioInputError if the place cannot be written to, AudioFailure
/// if writing fails (disk full).
class WavWriter {
 public:
    WavWriter(const std::filesystem::path& file, double sample_rate_hz, std::size_t channels,
              SampleFormat format);
    ~WavWriter();

    /// Appends frames, interleaved: samples.size() is a multiple of the channels. Samples that are
    /// not finite are written as silence.
    void write(std::span<const float> interleaved);

    /// Samples of all channels that were not finite.
    std::int64_t muted_samples() const;

    void commit();

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
