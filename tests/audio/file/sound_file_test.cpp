#include "aula/audio/sound_file.h"

#include <sndfile.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <numbers>
#include <span>
#include <string>

#include "aula/exception.h"

namespace sound_file_test {

using namespace aula;
namespace fs = std::filesystem;

namespace {

/// A temporary folder, removed by the destructor.
class TemporaryFolder {
 public:
    TemporaryFolder() {
        std::string name = (fs::temp_directory_path() / "aula-test-XXXXXX").string();
        REQUIRE(mkdtemp(name.data()) != nullptr);
        path_ = name;
    }
    ~TemporaryFolder() { fs::remove_all(path_); }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    fs::path operator/(const std::string& name) const { return path_ / name; }
    bool empty() const { return fs::is_empty(path_); }
    const fs::path& path() const { return path_; }

 private:
    fs::path path_;
};

std::string bytes(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

void write_wav(const fs::path& file, double rate_hz, std::size_t channels,
               const std::vector<float>& interleaved, SampleFormat format = SampleFormat::float32) {
    WavWriter writer(file, rate_hz, channels, format);
    writer.write(interleaved);
    writer.commit();
}

std::string error_of(const fs::path& file) {
    try {
        read_sound(file, 48000);
    } catch (const InputError& error) {
        return error.what();
    }
    return {};
}

}  // namespace

TEST_CASE("A float WAV file is read back exactly") {
    const TemporaryFolder folder;
    const std::vector<float> samples{0.1F, -2.5F, 1e-20F, 0.75F};
    write_wav(folder / "a.wav", 48000, 1, samples);
    const SoundClip clip = read_sound(folder / "a.wav", 48000);
    CHECK(clip.samples == samples);
    CHECK(clip.warnings.empty());
    CHECK(sound_info(folder / "a.wav").samples == 4);
    CHECK(sound_info(folder / "a.wav").sample_rate_hz == 48000);
}

TEST_CASE("The same sound gives the same bytes in every format") {
    const TemporaryFolder folder;
    const SampleFormat format =
        GENERATE(SampleFormat::float32, SampleFormat::pcm24, SampleFormat::pcm16);
    const std::vector<float> samples{0.5F, -0.5F, 0.25F, 0.125F};
    write_wav(folder / "a.wav", 48000, 2, samples, format);
    write_wav(folder / "b.wav", 48000, 2, samples, format);
    const std::string a = bytes(folder / "a.wav");
    CHECK(a == bytes(folder / "b.wav"));
    // The peak chunk contains the time of writing.
    CHECK(a.find("PEAK") == std::string::npos);
    CHECK(sound_info(folder / "a.wav").channels == 2);
}

TEST_CASE("Integer formats clip instead of wrapping around") {
    const TemporaryFolder folder;
    write_wav(folder / "a.wav", 48000, 1, {1.5F, -1.5F}, SampleFormat::pcm16);
    const SoundClip clip = read_sound(folder / "a.wav", 48000);
    CHECK(clip.samples[0] > 0.99F);
    CHECK(clip.samples[1] < -0.99F);
}

TEST_CASE("Integers are dithered by their seed, or rounded without one") {
    const TemporaryFolder folder;
    // -1/8 step of 16 bits, and less of 24.
    const std::vector<float> samples(4800, -0x1p-18F);
    const auto [format, steps_per_scale] =
        GENERATE(std::pair{SampleFormat::pcm24, 0x1p23F}, std::pair{SampleFormat::pcm16, 0x1p15F});
    const auto written = [&, kind = format](std::optional<std::uint64_t> seed) {
        WavWriter writer(folder / "a.wav", 48000, 1, kind, seed);
        writer.write(samples);
        writer.commit();
        return read_sound(folder / "a.wav", 48000).samples;
    };
    const float rounded = std::round(samples[0] * steps_per_scale) / steps_per_scale;
    CHECK(written(std::nullopt) == std::vector<float>(samples.size(), rounded));
    CHECK(written(3) == written(3));
    CHECK(written(3) != written(4));
    double mean = 0;
    for (const float sample : written(3))
        mean += double{sample} * double{steps_per_scale} / static_cast<double>(samples.size());
    // Statistical, 5 standard errors of the variance 1/4.
    CHECK(std::abs(mean - double{samples[0]} * double{steps_per_scale}) <
          5 * std::sqrt(0.25 / static_cast<double>(samples.size())));
}

TEST_CASE("Several channels are mixed down with a warning") {
    const TemporaryFolder folder;
    write_wav(folder / "a.wav", 48000, 4, {1, 0, 0, 0, 0.5F, 0.5F, 0.5F, 0.5F});
    const SoundClip clip = read_sound(folder / "a.wav", 48000);
    CHECK(clip.samples == std::vector<float>{0.25F, 0.5F});
    REQUIRE(clip.warnings.size() == 1);
    CHECK(clip.warnings[0] == (folder / "a.wav").string() + ": 4 channels mixed down to one");
}

TEST_CASE("Another sample rate is converted without delay or loss of level") {
    const TemporaryFolder folder;
    constexpr double kTone_hz = 1000;
    std::vector<float> tone(44100);
    for (std::size_t n = 0; n < tone.size(); ++n) {
        tone[n] = static_cast<float>(
            std::sin(2 * std::numbers::pi * kTone_hz * static_cast<double>(n) / 44100));
    }
    write_wav(folder / "a.wav", 44100, 1, tone);
    const SoundClip clip = read_sound(folder / "a.wav", 48000);
    REQUIRE(clip.samples.size() == 48000);
    // Excluding the ends, where the tone is switched on and off. soxr's HQ has a precision of 20
    // bits.
    double worst = 0;
    for (std::size_t n = 2000; n < 46000; ++n) {
        const double expected =
            std::sin(2 * std::numbers::pi * kTone_hz * static_cast<double>(n) / 48000);
        worst = std::max(worst, std::abs(double{clip.samples[n]} - expected));
    }
    CHECK(worst < 1e-5);
}

TEST_CASE("The error for an unreadable sound file is one line with its name") {
    const TemporaryFolder folder;
    std::ofstream(folder / "text.wav") << "this is no sound";
    fs::create_directory(folder / "folder.wav");
    write_wav(folder / "empty.wav", 48000, 1, {});
    for (const std::string name : {"missing.wav", "text.wav", "folder.wav", "empty.wav"}) {
        const std::string error = error_of(folder / name);
        CAPTURE(error);
        CHECK(error.starts_with((folder / name).string() + ": "));
        CHECK(error.find('\n') == std::string::npos);
        CHECK(error.find("expected") != std::string::npos);
    }
    CHECK_THROWS_AS(sound_info(folder / "text.wav"), InputError);
}

TEST_CASE("Samples that are not finite are read as silence with a warning") {
    const TemporaryFolder folder;
    // WavWriter would mute them.
    SF_INFO info{};
    info.samplerate = 48000;
    info.channels = 1;
    info.format = SF_FORMAT_WAV | SF_FORMAT_FLOAT;
    SNDFILE* const sound = sf_open((folder / "a.wav").c_str(), SFM_WRITE, &info);
    REQUIRE(sound != nullptr);
    const std::array samples{0.5F, NAN, INFINITY, 0.25F};
    sf_writef_float(sound, samples.data(), 4);
    sf_close(sound);
    const SoundClip clip = read_sound(folder / "a.wav", 48000);
    CHECK(clip.samples == std::vector<float>{0.5F, 0, 0, 0.25F});
    CHECK(clip.warnings.size() == 1);
}

TEST_CASE("Samples that are not finite are written as silence and counted") {
    const TemporaryFolder folder;
    const fs::path file = folder / "out.wav";
    WavWriter writer(file, 48000, 2, SampleFormat::float32);
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    writer.write(std::array{0.5F, kInfinity, 0.25F, 0.25F});
    CHECK(writer.muted_samples() == 1);
    writer.write(std::array{-kInfinity, std::numeric_limits<float>::quiet_NaN()});
    CHECK(writer.muted_samples() == 3);
    writer.commit();
    const SoundClip read = read_sound(file, 48000);
    CHECK(read.samples == std::vector<float>{0.25F, 0.25F, 0});
    // The warning about mixing down; a sample that is not finite would cause a second one.
    CHECK(read.warnings.size() == 1);
}

TEST_CASE("A sound shorter than half an output sample gives one sample") {
    const TemporaryFolder folder;
    write_wav(folder / "a.wav", 192000, 1, {0.5F});
    const SoundClip clip = read_sound(folder / "a.wav", 8000);
    REQUIRE(clip.samples.size() == 1);
    CHECK(std::isfinite(clip.samples[0]));
}

TEST_CASE("Implausible sample rates and numbers of channels are refused") {
    const TemporaryFolder folder;
    write_wav(folder / "a.wav", 48000, 1, std::vector<float>(48000, 0.5F));
    // Fields of the header, as in a damaged file.
    const auto with_field = [&](const std::string& name, std::size_t offset, std::uint32_t value,
                                std::size_t size) {
        std::string content = bytes(folder / "a.wav");
        for (std::size_t i = 0; i < size; ++i)
            content[offset + i] = static_cast<char>(value >> (8 * i));
        std::ofstream(folder / name, std::ios::binary) << content;
        return error_of(folder / name);
    };
    constexpr std::size_t kChannels = 22;
    constexpr std::size_t kRate = 24;
    CHECK(with_field("rate.wav", kRate, 1, 4) ==
          (folder / "rate.wav").string() +
              ": has a sample rate of 1 Hz; expected 1000 to 768000 Hz");
    CHECK(with_field("fast.wav", kRate, 768'001, 4).find("sample rate") != std::string::npos);
    CHECK(with_field("channels.wav", kChannels, 65, 2) ==
          (folder / "channels.wav").string() + ": has 65 channels; expected 1 to 64");
    CHECK_FALSE(with_field("none.wav", kChannels, 0, 2).empty());
}

TEST_CASE("A sound of more than 2^28 samples at the new rate is refused with the longest time") {
    const TemporaryFolder folder;
    const fs::path file = folder / "long.wav";
    constexpr std::size_t kLongest = (std::size_t{1} << 28U) / 192;
    write_wav(file, 1000, 1, std::vector<float>(kLongest + 1000));
    CHECK_THROWS_WITH(read_sound(file, 192000), file.string() + ": is too long; expected at most " +
                                                    std::to_string(kLongest / 1000) +
                                                    " s of 1000 Hz");
    CHECK_NOTHROW(read_sound(file, 2000));
}

TEST_CASE("Sound formats are identified by their first bytes, not by the name of the file") {
    const fs::path corpus = AULA_SOURCE_DIR "/tests/fuzz/corpus/sound";
    const TemporaryFolder folder;
    for (const char* name : {"aiff", "alac", "au", "caf", "flac", "mp3", "nist", "opus", "rf64",
                             "vorbis", "w64", "wav_pcm16", "wavex24"}) {
        CAPTURE(name);
        CHECK_FALSE(read_sound(corpus / name, 48000).samples.empty());
        // A tag before the sound is skipped.
        std::ofstream(folder / name, std::ios::binary)
            << std::string("ID3\4\0\0\0\0\0\4", 10) << "none" << bytes(corpus / name);
        CHECK(error_of(folder / name).find("has an unknown format") == std::string::npos);
    }
    for (const char* name : {"avr", "htk", "ircam", "mat4", "mat5", "mpc2k", "paf", "pvf", "sds",
                             "svx", "voc", "wve", "xi"}) {
        CAPTURE(name);
        CHECK(error_of(corpus / name).find("has an unknown format") != std::string::npos);
    }
}

TEST_CASE("A sound file that ends soon after its tag is not completed from the tag") {
    const TemporaryFolder folder;
    // The bytes 8 to 11 of the tag are "WAVE", as in a WAV file; two of them are its size.
    const std::size_t size = std::size_t{'W'} << 7 | 'A';
    const std::string tag = std::string("ID3\4\0\0\0\0WA", 10) + "VE" + std::string(size - 2, ' ');
    for (const char* rest : {"RIFF", ""}) {
        std::ofstream(folder / "tag.wav", std::ios::binary) << tag << rest;
        CAPTURE(rest);
        CHECK(error_of(folder / "tag.wav").find("has an unknown format") != std::string::npos);
    }
}

TEST_CASE("A pipe or a device is not read as sound") {
    const TemporaryFolder folder;
    REQUIRE(mkfifo((folder / "pipe.wav").c_str(), 0600) == 0);
    for (const fs::path& file : {folder / "pipe.wav", fs::path("/dev/zero")})
        CHECK(error_of(file) == file.string() + ": is not a regular file; expected a sound file");
}

TEST_CASE("A truncated sound file is read to its end with a warning") {
    const TemporaryFolder folder;
    std::vector<float> tone(20000);
    for (std::size_t n = 0; n < tone.size(); ++n)
        tone[n] = 0.5F * static_cast<float>(std::sin(0.1 * static_cast<double>(n)));
    SF_INFO info{};
    info.samplerate = 48000;
    info.channels = 1;
    info.format = SF_FORMAT_FLAC | SF_FORMAT_PCM_16;
    const fs::path file = folder / "a.flac";
    SNDFILE* const sound = sf_open(file.c_str(), SFM_WRITE, &info);
    REQUIRE(sound != nullptr);
    sf_writef_float(sound, tone.data(), static_cast<sf_count_t>(tone.size()));
    sf_close(sound);
    fs::resize_file(file, fs::file_size(file) / 2);
    const SoundClip clip = read_sound(file, 48000);
    CHECK(clip.samples.size() < tone.size());
    REQUIRE(clip.warnings.size() == 1);
    CHECK(clip.warnings[0].find(" of 20000 samples") != std::string::npos);
}

TEST_CASE("A WAV or AIFF file that is cut off is read to its end with a warning") {
    const TemporaryFolder folder;
    const std::vector<float> samples(1000, 0.25F);
    SF_INFO info{};
    info.samplerate = 48000;
    info.channels = 1;
    for (const int format : {SF_FORMAT_WAV | SF_FORMAT_PCM_16, SF_FORMAT_AIFF | SF_FORMAT_PCM_16}) {
        CAPTURE(format);
        info.format = format;
        const fs::path file = folder / "a.wav";
        SNDFILE* const sound = sf_open(file.c_str(), SFM_WRITE, &info);
        REQUIRE(sound != nullptr);
        sf_writef_float(sound, samples.data(), static_cast<sf_count_t>(samples.size()));
        sf_close(sound);
        CHECK(read_sound(file, 48000).warnings.empty());
        // A byte of padding may be counted but missing.
        fs::resize_file(file, fs::file_size(file) - 1);
        CHECK(read_sound(file, 48000).warnings.empty());
        fs::resize_file(file, fs::file_size(file) - 500);
        const SoundClip clip = read_sound(file, 48000);
        CHECK(clip.samples.size() < 800);
        CHECK(clip.warnings ==
              std::vector<std::string>{file.string() +
                                       ": is cut off: 501 bytes are missing at its end"});
    }
    // The size that a program writes into a pipe.
    const fs::path piped = folder / "piped.wav";
    write_wav(piped, 48000, 1, samples);
    std::fstream(piped, std::ios::binary | std::ios::in | std::ios::out)
        .seekp(4)
        .write("\xff\xff\xff\xff", 4);
    CHECK(read_sound(piped, 48000).warnings.empty());
}

TEST_CASE("Samples too large to be filtered are read as silence with a warning") {
    const TemporaryFolder folder;
    std::vector<float> samples(1000, 0.25F);
    samples[500] = 3e38F;
    samples[600] = 1.1e6F;
    write_wav(folder / "a.wav", 44100, 1, samples);
    const SoundClip clip = read_sound(folder / "a.wav", 48000);
    REQUIRE(clip.warnings.size() == 1);
    CHECK(clip.warnings[0].ends_with(
        ": 2 samples that are not finite, or beyond 1e6, taken as silence"));
    for (const float x : clip.samples) CHECK(std::abs(x) < 1);
}

TEST_CASE("Without commit no file is left and an existing file is kept") {
    const TemporaryFolder folder;
    {
        WavWriter writer(folder / "a.wav", 48000, 1, SampleFormat::float32);
        writer.write(std::vector<float>(1000, 0.5F));
    }
    CHECK(folder.empty());
    write_wav(folder / "a.wav", 48000, 1, {0.5F});
    const std::string before = bytes(folder / "a.wav");
    {
        WavWriter writer(folder / "a.wav", 48000, 1, SampleFormat::float32);
        writer.write(std::vector<float>(1000, 0.5F));
    }
    CHECK(bytes(folder / "a.wav") == before);
    CHECK(std::distance(fs::directory_iterator(folder.path()), {}) == 1);
}

TEST_CASE("A name that cannot be written is an input error") {
    const TemporaryFolder folder;
    fs::create_directory(folder / "folder.wav");
    for (const fs::path& file :
         {folder / "folder.wav", folder / "no/such/folder/a.wav", fs::path("/dev/null")}) {
        CAPTURE(file);
        CHECK_THROWS_AS(WavWriter(file, 48000, 1, SampleFormat::float32), InputError);
    }
    CHECK(fs::is_character_file("/dev/null"));
}

TEST_CASE("Writing to a full disk fails with an error and leaves no file") {
    const TemporaryFolder folder;
    // A limit on file sizes makes write() return short counts, like a full disk.
    rlimit before{};
    REQUIRE(getrlimit(RLIMIT_FSIZE, &before) == 0);
    const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
    // In the header's first byte, within the header, in the samples.
    const auto bytes = GENERATE(rlim_t{0}, rlim_t{20}, rlim_t{65536});
    CAPTURE(bytes);
    const rlimit small{bytes, before.rlim_max};
    REQUIRE(setrlimit(RLIMIT_FSIZE, &small) == 0);
    std::string error;
    try {
        WavWriter writer(folder / "a.wav", 48000, 1, SampleFormat::float32);
        for (int i = 0; i < 100; ++i) writer.write(std::vector<float>(1000, 0.5F));
        writer.commit();
    } catch (const Failure& failure) {
        error = failure.what();
    }
    REQUIRE(setrlimit(RLIMIT_FSIZE, &before) == 0);
    std::signal(SIGXFSZ, old_handler);
    CHECK(error.starts_with((folder / "a.wav").string() +
                            ": writing failed: " + std::strerror(EFBIG)));
    CHECK(folder.empty());
}

TEST_CASE(
    "More than two channels are written with the extensible header, others with the plain one") {
    const TemporaryFolder folder;
    for (const std::size_t channels : {1U, 2U, 4U}) {
        CAPTURE(channels);
        const fs::path file = folder / "a.wav";
        write_wav(file, 48000, channels, std::vector<float>(channels, 0.5F));
        SF_INFO info{};
        SNDFILE* const sound = sf_open(file.c_str(), SFM_READ, &info);
        REQUIRE(sound != nullptr);
        sf_close(sound);
        CHECK((info.format & SF_FORMAT_TYPEMASK) ==
              (channels > 2 ? SF_FORMAT_WAVEX : SF_FORMAT_WAV));
    }
}

TEST_CASE("Sample rate conversion preserves the duration to the nearest sample") {
    const TemporaryFolder folder;
    write_wav(folder / "a.wav", 44100, 1, std::vector<float>(100, 0.5F));
    // 100 / 44100 s are 108.84 and 36.28 samples.
    CHECK(read_sound(folder / "a.wav", 48000).samples.size() == 109);
    CHECK(read_sound(folder / "a.wav", 16000).samples.size() == 36);
}

TEST_CASE("Every format, sample rate and number of channels is written and read back") {
    const TemporaryFolder folder;
    // Half a step of the format; floats are exact. Dither is up to one step.
    const auto [format, error] =
        GENERATE(std::pair{SampleFormat::float32, 0.0}, std::pair{SampleFormat::pcm24, 0x1p-24},
                 std::pair{SampleFormat::pcm16, 0x1p-16});
    for (const auto& [rate_hz, channels] : {std::pair{8000.0, 1U},
                                            {11025.0, 2U},
                                            {44100.0, 3U},
                                            {48000.0, 4U},
                                            {96000.0, 16U},
                                            {192000.0, 64U}}) {
        constexpr std::size_t kFrames = 50;
        std::vector<float> samples;
        std::vector<double> mean(kFrames);
        for (std::size_t n = 0; n < kFrames; ++n) {
            for (std::size_t c = 0; c < channels; ++c) {
                samples.push_back(0.9F * std::sin(static_cast<float>(n * n + 7 * c)));
                mean[n] += double{samples.back()} / static_cast<double>(channels);
            }
        }
        const fs::path file = folder / "a.wav";
        write_wav(file, rate_hz, channels, samples, format);
        const SoundInfo info = sound_info(file);
        CAPTURE(rate_hz, channels, error);
        CHECK(info.sample_rate_hz == rate_hz);
        CHECK(info.channels == static_cast<int>(channels));
        CHECK(info.samples == kFrames);
        const SoundClip clip = read_sound(file, rate_hz);
        REQUIRE(clip.samples.size() == kFrames);
        CHECK(clip.sample_rate_hz == rate_hz);
        CHECK(clip.warnings.size() == (channels > 1 ? 1U : 0U));
        for (std::size_t n = 0; n < kFrames; ++n) {
            // Rounding of the mean.
            const double bound = 3 * error + (channels > 1 ? 0x1p-24 * 8 : 0);
            CHECK(std::abs(double{clip.samples[n]} - mean[n]) <= bound);
        }
    }
}

TEST_CASE("A sound written in parts equals one written at a time, to the byte") {
    const TemporaryFolder folder;
    std::vector<float> samples(6000);
    for (std::size_t n = 0; n < samples.size(); ++n)
        samples[n] = std::sin(static_cast<float>(n * n % 1009));
    for (const SampleFormat format : {SampleFormat::float32, SampleFormat::pcm16}) {
        write_wav(folder / "whole.wav", 48000, 2, samples, format);
        WavWriter writer(folder / "parts.wav", 48000, 2, format);
        for (std::size_t done = 0, frames = 1; done < samples.size(); frames = 3 * frames % 500) {
            const std::size_t count = std::min(2 * frames, samples.size() - done);
            writer.write(std::span(samples).subspan(done, count));
            done += count;
        }
        writer.write({});
        writer.commit();
        CHECK(bytes(folder / "parts.wav") == bytes(folder / "whole.wav"));
    }
}

TEST_CASE("A sound of several blocks of the reader is read to its last sample") {
    const TemporaryFolder folder;
    // Blocks of 16384 samples.
    for (const std::size_t frames : {16383U, 16384U, 16385U, 40000U}) {
        std::vector<float> samples(frames);
        for (std::size_t n = 0; n < frames; ++n)
            samples[n] = static_cast<float>(n) / static_cast<float>(frames);
        write_wav(folder / "a.wav", 48000, 1, samples);
        CHECK(read_sound(folder / "a.wav", 48000).samples == samples);
    }
}

TEST_CASE("A sample rate that is not whole is written rounded to nearest") {
    const TemporaryFolder folder;
    for (const auto& [rate_hz, written_hz] : {std::pair{44099.6, 44100}, {48000.4, 48000}}) {
        write_wav(folder / "a.wav", rate_hz, 1, {0.5F});
        CHECK(sound_info(folder / "a.wav").sample_rate_hz == written_hz);
    }
}

}  // namespace sound_file_test
