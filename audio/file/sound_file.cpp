#include "aula/audio/sound_file.h"

#include <fcntl.h>
#include <sndfile.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <mutex>
#include <optional>
#include <string_view>
#include <system_error>

#include "audio/base/mute.h"
#include "audio/dsp/resample.h"
#include "audio/file/part_file.h"
#include "aula/exception.h"

namespace aula {

namespace fs = std::filesystem;

namespace {

struct CloseSound {
    void operator()(SNDFILE* file) const { sf_close(file); }
};
using SoundHandle = std::unique_ptr<SNDFILE, CloseSound>;

/// While one exists, what the process writes to standard error is lost: the MPEG decoder reports
/// each damaged frame there.
class NoStandardError {
 public:
    NoStandardError() : lock_(mutex()), kept_(fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3)) {
        const int null = open("/dev/null", O_WRONLY | O_CLOEXEC);
        if (kept_ >= 0 && null >= 0) dup2(null, STDERR_FILENO);
        if (null >= 0) close(null);
    }
    ~NoStandardError() {
        if (kept_ < 0) return;
        dup2(kept_, STDERR_FILENO);
        close(kept_);
    }
    NoStandardError(const NoStandardError&) = delete;
    NoStandardError& operator=(const NoStandardError&) = delete;

 private:
    static std::mutex& mutex() {
        static std::mutex of_process;
        return of_process;
    }

    std::lock_guard<std::mutex> lock_;
    int kept_;
};

struct OpenSound {
    std::unique_ptr<NoStandardError> quiet;  ///< for MPEG; ends after the file is closed
    SoundHandle handle;
};

enum class Kind { unknown, mpeg, other };

constexpr int kLowestRate_hz = 1000;
constexpr int kHighestRate_hz = 768'000;
constexpr int kMaxChannels = 64;                           // ambisonics of order 7
constexpr std::size_t kMaxSamples = std::size_t{1} << 28;  // 1 GiB; 93 minutes at 48 kHz
constexpr float kLargestSample = 0x1p31F;  // full scale of 32-bit integers; no format has more

[[noreturn]] void fail(const fs::path& file, const std::string& problem) {
    throw InputError(file.string() + ": " + problem);
}

/// The kind of the supported format that the file begins like. libsndfile also detects others, but
/// its SDS reader prints on standard output.
Kind kind_of(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::array<char, 12> head{};
    const auto holds = [&](std::string_view text, std::size_t at) {
        return std::string_view(head.data(), head.size()).substr(at).starts_with(text);
    };
    const auto read_head = [&] {
        head = {};
        stream.read(head.data(), head.size());
    };
    read_head();
    while (
        holds("ID3", 0)) {  // a tag: a header of 10 bytes with the size of the rest in 4 x 7 bits
        std::streamoff size = 0;
        for (std::size_t i = 6; i < 10; ++i) size = size << 7 | (head[i] & 0x7F);
        stream.seekg(10 + size - stream.gcount(), std::ios::cur);
        read_head();
    }
    if (head[0] == '\xFF' && (head[1] & 0xE0) == 0xE0) return Kind::mpeg;
    constexpr std::string_view kOthers[] = {
        "riff\x2E\x91\xCF\x11", ".snd", "dns.", "caff", "fLaC", "OggS", "NIST_1A"};
    const bool is_wave = holds("RIFF", 0) || holds("RIFX", 0) || holds("RF64", 0);
    const bool is_known =
        is_wave            ? holds("WAVE", 8)
        : holds("FORM", 0) ? holds("AIF", 8)
                           : std::any_of(std::begin(kOthers), std::end(kOthers),
                                         [&](std::string_view begin) { return holds(begin, 0); });
    return is_known ? Kind::other : Kind::unknown;
}

/// Bytes that the header of a RIFF or AIFF file promises and the file lacks. A program that writes
/// into a pipe does not know the size; what it writes instead is above 2 GB.
std::uint64_t missing_bytes(const fs::path& file) {
    constexpr std::uint64_t kLargestKnown = 0x7FFF'0000;
    std::ifstream stream(file, std::ios::binary);
    std::array<unsigned char, 8> head{};
    stream.read(reinterpret_cast<char*>(head.data()), head.size());
    const std::string_view form(reinterpret_cast<const char*>(head.data()), 4);
    const bool little = form == "RIFF";
    if (!stream || (!little && form != "RIFX" && form != "FORM")) return 0;
    std::uint64_t promised = 8;
    for (std::size_t i = 0; i < 4; ++i)
        promised += std::uint64_t{head[little ? 4 + i : 7 - i]} << (8 * i);
    std::error_code error;
    const std::uint64_t size = fs::file_size(file, error);
    if (error) return 0;
    // Some programs count a byte of padding that they do not write.
    return promised > kLargestKnown || size + 1 >= promised ? 0 : promised - size;
}

OpenSound open_sound(const fs::path& file, SF_INFO& info) {
    constexpr const char* kExpected =
        "; expected WAV, RF64, W64, AIFF, AU, CAF, FLAC, Ogg, MP3 or NIST SPHERE";
    std::error_code error;
    const fs::file_status status = fs::status(file, error);
    if (!fs::exists(status)) fail(file, "no such file; expected a sound file");
    // Opening a pipe would block; reading a device might not end.
    if (!fs::is_regular_file(status)) fail(file, "is not a regular file; expected a sound file");
    const Kind kind = kind_of(file);
    if (kind == Kind::unknown) fail(file, std::string("has an unknown format") + kExpected);
    OpenSound sound;
    if (kind == Kind::mpeg) sound.quiet = std::make_unique<NoStandardError>();
    info = {};
    // An absolute name: libsndfile reads "-" as standard input.
    sound.handle.reset(sf_open(fs::absolute(file).c_str(), SFM_READ, &info));
    if (!sound.handle) fail(file, std::string("cannot be read as sound") + kExpected);
    if (info.samplerate < kLowestRate_hz || info.samplerate > kHighestRate_hz) {
        fail(file, "has a sample rate of " + std::to_string(info.samplerate) +
                       " Hz; expected 1000 to 768000 Hz");
    }
    if (info.channels < 1 || info.channels > kMaxChannels) {
        fail(file, "has " + std::to_string(info.channels) + " channels; expected 1 to " +
                       std::to_string(kMaxChannels));
    }
    return sound;
}

}  // namespace

SoundInfo sound_info(const fs::path& file) {
    SF_INFO info;
    open_sound(file, info);
    return {info.frames, static_cast<double>(info.samplerate), info.channels};
}

SoundClip read_sound(const fs::path& file, double sample_rate_hz) {
    SF_INFO info;
    const OpenSound open = open_sound(file, info);
    SNDFILE* const sound = open.handle.get();
    const auto channels = static_cast<std::size_t>(info.channels);

    SoundClip clip;
    clip.sample_rate_hz = sample_rate_hz;
    constexpr sf_count_t kBlock = 16384;
    std::vector<float> interleaved(static_cast<std::size_t>(kBlock) * channels);
    const auto max = static_cast<std::size_t>(static_cast<double>(kMaxSamples) *
                                              std::min(1.0, info.samplerate / sample_rate_hz));
    bool usable = true;
    while (true) {
        const sf_count_t got = sf_readf_float(sound, interleaved.data(), kBlock);
        if (got <= 0) break;
        if (clip.samples.size() + static_cast<std::size_t>(got) > max) {
            fail(file, "is too long; expected at most " +
                           std::to_string(max / static_cast<std::size_t>(info.samplerate)) +
                           " s of " + std::to_string(info.samplerate) + " Hz");
        }
        for (std::size_t i = 0; i < static_cast<std::size_t>(got); ++i) {
            float sum = 0;
            for (std::size_t c = 0; c < channels; ++c) sum += interleaved[i * channels + c];
            float sample = sum / static_cast<float>(channels);
            // The comparison fails for NaN, too.
            if (!(std::abs(sample) <= kLargestSample)) {
                sample = 0;
                usable = false;
            }
            clip.samples.push_back(sample);
        }
    }
    if (sf_error(sound) != SF_ERR_NO_ERROR) {
        fail(file, "is damaged and cannot be read to its end; expected a whole sound file");
    }
    if (clip.samples.empty()) fail(file, "has no samples; expected at least one");
    const auto read = static_cast<sf_count_t>(clip.samples.size());
    if (read < info.frames && info.frames != SF_COUNT_MAX) {
        clip.warnings.push_back(file.string() + ": ends after " + std::to_string(read) + " of " +
                                std::to_string(info.frames) + " samples");
    }
    if (const std::uint64_t missing = missing_bytes(file); missing > 0) {
        clip.warnings.push_back(file.string() + ": is cut off: " + std::to_string(missing) +
                                " bytes are missing at its end");
    }
    if (channels > 1) {
        clip.warnings.push_back(file.string() + ": " + std::to_string(channels) +
                                " channels mixed down to one");
    }
    if (!usable) {
        clip.warnings.push_back(file.string() +
                                ": samples that are not numbers, or too large, taken as silence");
    }
    clip.samples = resample(clip.samples, 1, info.samplerate, sample_rate_hz);
    return clip;
}

struct WavWriter::State {
    fs::path name;  ///< as the user gave it, for messages
    std::size_t channels = 0;
    std::optional<PartFile> part;
    SoundHandle sound;
    std::vector<float> finite;  ///< samples of a write(), muted where not finite
    std::int64_t muted = 0;

    [[noreturn]] void fail(const std::string& why) const {
        throw Failure(name.string() + ": writing failed: " + why + "; no file was written");
    }
};

WavWriter::WavWriter(const fs::path& file, double sample_rate_hz, std::size_t channels,
                     SampleFormat format)
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
            break;
        case SampleFormat::pcm16:
            info.format |= SF_FORMAT_PCM_16;
            break;
    }
    state_->sound.reset(sf_open_fd(state_->part->descriptor(), SFM_WRITE, &info, SF_FALSE));
    if (!state_->sound) state_->fail("a WAV file of this rate and format cannot be created");
    // The peak chunk contains the time of day; without it equal sounds give equal files.
    sf_command(state_->sound.get(), SFC_SET_ADD_PEAK_CHUNK, nullptr, SF_FALSE);
    sf_command(state_->sound.get(), SFC_SET_CLIPPING, nullptr, SF_TRUE);
}

WavWriter::~WavWriter() = default;

void WavWriter::write(std::span<const float> interleaved) {
    assert(interleaved.size() % state_->channels == 0);
    const auto count = static_cast<sf_count_t>(interleaved.size() / state_->channels);
    state_->finite.assign(interleaved.begin(), interleaved.end());
    state_->muted +=
        static_cast<std::int64_t>(mute_beyond(std::numeric_limits<float>::max(), state_->finite));
    errno = 0;
    if (sf_writef_float(state_->sound.get(), state_->finite.data(), count) != count) {
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
