#include "aula/audio/sound_file.h"

#include <sndfile.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <span>
#include <system_error>

#include "audio/base/mute.h"
#include "audio/dsp/resample.h"
#include "audio/file/embedded_sound_reader.h"
#include "audio/file/part_file.h"
#include "audio/file/sample_quantizer.h"
#include "audio/file/sound_answer.h"
#include "aula/exception.h"
#include "process/contained_process.h"

namespace aula {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMaxSamples = std::size_t{1} << 28;  // 1 GiB; 93 minutes at 48 kHz

/// Whether libsndfile was built with a format.
bool reads(int format) {
    int count = 0;
    sf_command(nullptr, SFC_GET_FORMAT_MAJOR_COUNT, &count, sizeof(count));
    for (SF_FORMAT_INFO known{}; count > 0; --count) {
        known.format = count - 1;
        sf_command(nullptr, SFC_GET_FORMAT_MAJOR, &known, sizeof(known));
        if (known.format == format) return true;
    }
    return false;
}

/// The formats of files that are read, for messages.
std::string readable_formats() {
    return std::string("WAV, RF64, W64, AIFF, AU, CAF") + (reads(SF_FORMAT_FLAC) ? ", FLAC" : "") +
           (reads(SF_FORMAT_OGG) ? ", Ogg" : "") + (reads(SF_FORMAT_MPEG) ? ", MP3" : "") +
           " or NIST SPHERE";
}

/// A sound file that is decoded in a child process: the decoders of libsndfile may loop and crash.
class DecodedFile {
 public:
    explicit DecodedFile(const fs::path& file)
        : file_(file), reader_(embedded_sound_reader(), file, kExpected) {
        read_header();
    }
    DecodedFile(std::string_view bytes, const fs::path& name)
        : file_(name), reader_(embedded_sound_reader(), bytes, name, kExpected) {
        read_header();
    }

    const SoundHeader& header() const { return header_; }

    /// The number of channels.
    std::size_t channels() const { return static_cast<std::size_t>(header_.channels); }

    /// Calls `take` with the samples of all channels at one time, one time after another, at most
    /// `longest` of them. Returns the warnings of what was read.
    template <typename Take>
    std::vector<std::string> read(std::size_t longest, const Take& take) {
        std::vector<float> block;
        std::size_t count = 0;
        while (read_block(block)) {
            count += block.size() / channels();
            if (count > longest)
                fail("is too long; expected at most " +
                     std::to_string(longest / static_cast<std::size_t>(header_.sample_rate_hz)) +
                     " s of " + std::to_string(header_.sample_rate_hz) + " Hz");
            for (std::size_t i = 0; i < block.size(); i += channels())
                take(std::span<const float>(block).subspan(i, channels()));
        }
        if (count == 0) fail("has no samples; expected at least one");
        std::vector<std::string> warnings;
        const auto warn = [&](const std::string& problem) {
            warnings.push_back(file_.string() + ": " + problem);
        };
        if (static_cast<std::int64_t>(count) < header_.samples &&
            header_.samples != SoundHeader::kUnknown)
            warn("ends after " + std::to_string(count) + " of " + std::to_string(header_.samples) +
                 " samples");
        if (header_.missing_bytes > 0)
            warn("is cut off: " + std::to_string(header_.missing_bytes) +
                 " bytes are missing at its end");
        return warnings;
    }

    [[noreturn]] void fail(const std::string& problem) const {
        throw InputError(file_.string() + ": " + problem);
    }

 private:
    static constexpr const char* kExpected = "a sound file";

    void read_header() {
        using Verdict = SoundHeader::Verdict;
        reader_.read(header_);
        if (header_.verdict == Verdict::unknown_format)
            fail("has an unknown format; expected " + readable_formats());
        if (header_.magic != SoundHeader::kMagic || header_.verdict == Verdict::unreadable)
            fail("cannot be read as sound; expected " + readable_formats());
        switch (header_.verdict_of_format()) {
            case Verdict::usable:
                break;
            case Verdict::wrong_rate:
                fail("has a sample rate of " + std::to_string(header_.sample_rate_hz) +
                     " Hz; expected " + std::to_string(SoundHeader::kLowestRate_hz) + " to " +
                     std::to_string(SoundHeader::kHighestRate_hz) + " Hz");
            default:
                fail("has " + std::to_string(header_.channels) + " channels; expected 1 to " +
                     std::to_string(SoundHeader::kMaxChannels));
        }
    }

    /// Reads the next samples of all channels, interleaved. Returns false after the last ones.
    bool read_block(std::vector<float>& samples) {
        SoundBlock block;
        reader_.read(block);
        if (block.samples > SoundBlock::kMaxSamples || block.samples % channels() != 0 ||
            block.damaged != 0)
            fail("is damaged and cannot be read to its end; expected a whole sound file");
        samples.resize(block.samples);
        reader_.read_bytes(samples.data(), block.samples * sizeof(float));
        return block.samples > 0;
    }

    fs::path file_;
    ContainedProcess reader_;
    SoundHeader header_;
};

/// Samples beyond 1e6 become silence, with a warning for the file.
void mute(std::vector<float>& samples, const fs::path& file, std::vector<std::string>& warnings) {
    if (const std::size_t muted = mute_beyond(kLargestSample, samples); muted > 0)
        warnings.push_back(file.string() + ": " + std::to_string(muted) +
                           " samples that are not finite, or beyond 1e6, taken as silence");
}

/// A sound that is mixed down and resampled.
SoundClip read_clip(DecodedFile& decoded, const fs::path& file, double sample_rate_hz) {
    const SoundHeader& header = decoded.header();

    SoundClip clip;
    clip.sample_rate_hz = sample_rate_hz;
    const auto longest = static_cast<std::size_t>(
        static_cast<double>(kMaxSamples) * std::min(1.0, header.sample_rate_hz / sample_rate_hz));
    clip.warnings = decoded.read(longest, [&](std::span<const float> channels) {
        float sum = 0;
        for (const float sample : channels) sum += sample;
        clip.samples.push_back(sum / static_cast<float>(channels.size()));
    });
    if (header.channels > 1)
        clip.warnings.push_back(file.string() + ": " + std::to_string(header.channels) +
                                " channels mixed down to one");
    // Resampling would spread them.
    mute(clip.samples, file, clip.warnings);
    clip.samples = resample(clip.samples, 1, header.sample_rate_hz, sample_rate_hz);
    return clip;
}

}  // namespace

SoundInfo sound_info(const fs::path& file) {
    const DecodedFile decoded(file);
    const SoundHeader& header = decoded.header();
    return {header.samples, static_cast<double>(header.sample_rate_hz), header.channels};
}

SoundClip read_sound(const fs::path& file, double sample_rate_hz) {
    DecodedFile decoded(file);
    return read_clip(decoded, file, sample_rate_hz);
}

SoundClip read_sound(std::string_view bytes, const fs::path& name, double sample_rate_hz) {
    DecodedFile decoded(bytes, name);
    return read_clip(decoded, name, sample_rate_hz);
}

SoundChannels read_channels(const fs::path& file) {
    DecodedFile decoded(file);
    SoundChannels sound;
    sound.sample_rate_hz = static_cast<double>(decoded.header().sample_rate_hz);
    sound.channels.resize(decoded.channels());
    sound.warnings =
        decoded.read(kMaxSamples / decoded.channels(), [&](std::span<const float> samples) {
            for (std::size_t c = 0; c < samples.size(); ++c)
                sound.channels[c].push_back(samples[c]);
        });
    for (std::vector<float>& channel : sound.channels) mute(channel, file, sound.warnings);
    return sound;
}

struct CloseSound {
    void operator()(SNDFILE* file) const { sf_close(file); }
};

struct WavWriter::State {
    fs::path name;  ///< as the user gave it, for messages
    std::size_t channels = 0;
    std::optional<PartFile> part;
    std::unique_ptr<SNDFILE, CloseSound> sound;
    std::optional<SampleQuantizer> quantizer;  ///< of integer formats
    std::vector<float> finite;                 ///< samples of a write(), muted where not finite
    std::vector<int> integers;                 ///< of a write(), by the quantizer
    std::int64_t muted = 0;

    [[noreturn]] void fail(const std::string& why) const {
        throw Failure(name.string() + ": writing failed: " + why + "; no file was written");
    }
};

WavWriter::WavWriter(const fs::path& file, double sample_rate_hz, std::size_t channels,
                     SampleFormat format, std::optional<std::uint64_t> dither_seed)
    : state_(std::make_unique<State>()) {
    state_->name = file;
    state_->channels = channels;
    std::error_code ignored;
    if (fs::exists(file, ignored) && !fs::is_regular_file(file, ignored)) {
        throw InputError(file.string() +
                         ": cannot be written: not a regular file; expected a file name");
    }
    try {
        state_->part.emplace(file);
    } catch (const std::system_error& error) {
        throw InputError(file.string() + ": cannot be written: " + error.code().message() +
                         "; expected a name in a folder that can be written to");
    }

    SF_INFO info{};
    info.samplerate = static_cast<int>(std::lround(sample_rate_hz));
    info.channels = static_cast<int>(channels);
    // More than two channels require the extensible header.
    info.format = channels > 2 ? SF_FORMAT_WAVEX : SF_FORMAT_WAV;
    switch (format) {
        case SampleFormat::float32:
            info.format |= SF_FORMAT_FLOAT;
            break;
        case SampleFormat::pcm24:
            info.format |= SF_FORMAT_PCM_24;
            state_->quantizer.emplace(24, dither_seed);
            break;
        case SampleFormat::pcm16:
            info.format |= SF_FORMAT_PCM_16;
            state_->quantizer.emplace(16, dither_seed);
            break;
    }
    // Opening writes the header.
    errno = 0;
    state_->sound.reset(sf_open_fd(state_->part->descriptor(), SFM_WRITE, &info, SF_FALSE));
    if (!state_->sound)
        state_->fail(errno != 0 ? std::strerror(errno)
                                : "a WAV file of this rate and format cannot be created");
    // The peak chunk contains the time of day; without it equal sounds give equal files.
    sf_command(state_->sound.get(), SFC_SET_ADD_PEAK_CHUNK, nullptr, SF_FALSE);
}

WavWriter::~WavWriter() = default;

void WavWriter::write(std::span<const float> interleaved) {
    assert(interleaved.size() % state_->channels == 0);
    const auto count = static_cast<sf_count_t>(interleaved.size() / state_->channels);
    state_->finite.assign(interleaved.begin(), interleaved.end());
    state_->muted +=
        static_cast<std::int64_t>(mute_beyond(std::numeric_limits<float>::max(), state_->finite));
    errno = 0;
    sf_count_t written = 0;
    if (state_->quantizer) {
        state_->quantizer->quantize(state_->finite, state_->integers);
        written = sf_writef_int(state_->sound.get(), state_->integers.data(), count);
    } else {
        written = sf_writef_float(state_->sound.get(), state_->finite.data(), count);
    }
    if (written != count) {
        state_->fail(errno != 0 ? std::strerror(errno) : "not all samples could be written");
    }
}

std::int64_t WavWriter::muted_samples() const { return state_->muted; }

void WavWriter::commit() {
    // Closing writes the lengths to the header and may detect a full disk.
    errno = 0;
    if (sf_close(state_->sound.release()) != 0) state_->fail(std::strerror(errno));
    try {
        state_->part->commit();
    } catch (const std::system_error& error) {
        state_->fail(error.code().message());
    }
}

}  // namespace aula
