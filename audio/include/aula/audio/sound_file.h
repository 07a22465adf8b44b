#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace aula {

/// A mono sound in memory.
struct SoundClip {
    double sample_rate_hz = 48000;  ///< of `samples`: the rate that was asked for
    std::vector<float> samples;     ///< full scale is 1; at least one sample
    /// One line each, such as "voice.wav: 2 channels mixed down to one".
    std::vector<std::string> warnings;
};

/// Reads a WAV (also RF64, W64), AIFF, AU, CAF, FLAC, Ogg, MP3 or NIST SPHERE file, mixes it down
/// to mono (the mean of its channels) and resamples it to `sample_rate_hz`. A child process decodes
/// the file. A file that is cut off is read to its end, with a warning. Samples that are not finite
/// or exceed 1e6 in magnitude become 0, with a warning. Throws InputError if the file cannot be
/// read or is of another format, and for sample rates outside 1 to 768 kHz, more than 64 channels,
/// no sample, or more than 2^28 samples before or after resampling; Failure if the child process
/// cannot be started.
SoundClip read_sound(const std::filesystem::path& file, double sample_rate_hz);

/// The same for the bytes of such a file; `name` is that in messages.
SoundClip read_sound(std::string_view bytes, const std::filesystem::path& name,
                     double sample_rate_hz);

/// The channels of a sound file at its sample rate.
struct SoundChannels {
    double sample_rate_hz = 0;                 ///< 1000 to 768000
    std::vector<std::vector<float>> channels;  ///< [channel][sample] full scale is 1; 1 to 64
    std::vector<std::string> warnings;         ///< as SoundClip::warnings
};

/// Reads the channels of a sound file, of at most 2^28 samples in all. Otherwise as read_sound().
SoundChannels read_channels(const std::filesystem::path& file);

/// What the header of a sound file says.
struct SoundInfo {
    std::int64_t samples = 0;   ///< length in samples of each channel
    double sample_rate_hz = 0;  ///< 1000 to 768000
    int channels = 0;           ///< 1 to 64
};

/// Reads the header of a sound file. Throws as read_sound().
SoundInfo sound_info(const std::filesystem::path& file);

/// How a WAV file represents samples. Integers are rounded and clipped to full scale, 1.
enum class SampleFormat {
    float32,  ///< 32-bit floating point, not clipped
    pcm24,    ///< 24-bit integers
    pcm16     ///< 16-bit integers
};

/// Writes a WAV file. It has a temporary name in its folder until commit() renames it.
/// Without commit() the destructor removes it. All functions throw Failure if writing fails, for
/// instance on a full disk.
class WavWriter {
 public:
    /// Creates the file with `channels` channels; the rate is rounded to whole Hz. An existing file
    /// is kept until commit() replaces it. Throws InputError if the folder is not writable, or if
    /// `file` exists and is write-protected or not a regular file. `dither_seed`: of the triangular
    /// dither of integer formats; empty: they are rounded without dither.
    WavWriter(const std::filesystem::path& file, double sample_rate_hz, std::size_t channels,
              SampleFormat format, std::optional<std::uint64_t> dither_seed = 1);
    ~WavWriter();

    /// Appends interleaved samples, [sample][channel]; the number is a multiple of the channels.
    /// Samples that are not finite are written as 0.
    void write(std::span<const float> interleaved);

    /// Number of samples of all channels that were not finite.
    std::int64_t muted_samples() const;

    /// Completes the file under its name. Nothing may be written afterwards.
    void commit();

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
