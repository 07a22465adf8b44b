#include "audio/file/sound_decoder.h"

#include <sndfile.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string_view>
#include <vector>

#include "audio/file/sound_answer.h"

namespace aula {

namespace {

using Bytes = std::span<const std::byte>;

struct CloseSound {
    void operator()(SNDFILE* file) const { sf_close(file); }
};

/// A file in memory, and the position in it, for libsndfile.
struct Input {
    Bytes bytes;
    sf_count_t position = 0;

    sf_count_t size() const { return static_cast<sf_count_t>(bytes.size()); }
};

Input& input(void* user) { return *static_cast<Input*>(user); }

SF_VIRTUAL_IO input_functions() {
    SF_VIRTUAL_IO functions{};
    functions.get_filelen = [](void* user) { return input(user).size(); };
    functions.seek = [](sf_count_t offset, int whence, void* user) -> sf_count_t {
        const sf_count_t origin = whence == SEEK_SET   ? 0
                                  : whence == SEEK_CUR ? input(user).position
                                                       : input(user).size();
        sf_count_t to = 0;
        if (__builtin_add_overflow(origin, offset, &to) || to < 0) return -1;
        return input(user).position = to;
    };
    functions.read = [](void* to, sf_count_t count, void* user) -> sf_count_t {
        const sf_count_t left = input(user).size() - input(user).position;
        count = std::min(count, left);
        if (count <= 0) return 0;
        std::memcpy(to, &input(user).bytes[static_cast<std::size_t>(input(user).position)],
                    static_cast<std::size_t>(count));
        input(user).position += count;
        return count;
    };
    functions.tell = [](void* user) { return input(user).position; };
    return functions;
}

std::string_view text(Bytes bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// The file without the ID3 tags that it begins with.
Bytes behind_tags(Bytes file) {
    constexpr std::size_t kHeader = 10;  // the last 4 bytes are the size of the rest, 7 bits each
    while (file.size() >= kHeader && text(file).starts_with("ID3")) {
        std::size_t size = 0;
        for (std::size_t i = 6; i < kHeader; ++i)
            size = size << 7 | (std::to_integer<std::size_t>(file[i]) & 0x7F);
        file = file.subspan(std::min(file.size(), kHeader + size));
    }
    return file;
}

/// Whether a file begins like one of a supported format. libsndfile also detects others, but its
/// SDS reader prints on standard output.
bool is_known(Bytes file) {
    const auto holds = [&](std::string_view mark, std::size_t at) {
        return file.size() >= at && text(file).substr(at).starts_with(mark);
    };
    if (file.size() < 2) return false;
    const auto mpeg = [](std::byte second) {
        return (second & std::byte{0xE0}) == std::byte{0xE0};
    };
    if (file[0] == std::byte{0xFF} && mpeg(file[1])) return true;
    if (holds("RIFF", 0) || holds("RIFX", 0) || holds("RF64", 0)) return holds("WAVE", 8);
    if (holds("FORM", 0)) return holds("AIF", 8);
    constexpr std::string_view kOthers[] = {
        "riff\x2E\x91\xCF\x11", ".snd", "dns.", "caff", "fLaC", "OggS", "NIST_1A"};
    return std::any_of(std::begin(kOthers), std::end(kOthers),
                       [&](std::string_view mark) { return holds(mark, 0); });
}

/// Bytes that the header of a RIFF or AIFF file promises and the file lacks. A program that writes
/// into a pipe does not know the size; what it writes instead is above 2 GB.
std::uint64_t missing_bytes(Bytes file) {
    constexpr std::uint64_t kLargestKnown = 0x7FFF'0000;
    const std::string_view form = text(file).substr(0, 4);
    const bool little = form == "RIFF";
    if (file.size() < 8 || (!little && form != "RIFX" && form != "FORM")) return 0;
    std::uint64_t promised = 8;
    for (std::size_t i = 0; i < 4; ++i)
        promised += std::to_integer<std::uint64_t>(file[little ? 4 + i : 7 - i]) << (8 * i);
    // Some programs count a byte of padding that they do not write.
    return promised > kLargestKnown || file.size() + 1 >= promised ? 0 : promised - file.size();
}

}  // namespace

void decode_sound(Bytes file, const std::function<bool(const void*, std::size_t)>& write) {
    SoundHeader header;
    Input sound_bytes{behind_tags(file)};
    SF_VIRTUAL_IO functions = input_functions();
    SF_INFO info{};
    std::unique_ptr<SNDFILE, CloseSound> sound;
    if (!is_known(sound_bytes.bytes)) {
        header.verdict = SoundHeader::Verdict::unknown_format;
    } else {
        sound.reset(sf_open_virtual(&functions, SFM_READ, &info, &sound_bytes));
    }
    if (sound) {
        header.sample_rate_hz = info.samplerate;
        header.channels = info.channels;
        header.samples = info.frames == SF_COUNT_MAX ? SoundHeader::kUnknown : info.frames;
        header.missing_bytes = missing_bytes(sound_bytes.bytes);
        header.verdict = header.verdict_of_format();
    }
    if (!write(&header, sizeof(header)) || header.verdict != SoundHeader::Verdict::usable) return;

    std::vector<float> interleaved(SoundBlock::kMaxSamples);
    const sf_count_t frames = sf_count_t{SoundBlock::kMaxSamples} / info.channels;
    while (true) {
        const sf_count_t got = sf_readf_float(sound.get(), interleaved.data(), frames);
        SoundBlock block;
        block.samples = static_cast<std::uint32_t>(std::max<sf_count_t>(got, 0) * info.channels);
        const bool is_last = block.samples == 0;
        if (is_last && sf_error(sound.get()) != SF_ERR_NO_ERROR) block.damaged = 1;
        if (!write(&block, sizeof(block)) ||
            !write(interleaved.data(), block.samples * sizeof(float)) || is_last)
            return;
    }
}

}  // namespace aula
