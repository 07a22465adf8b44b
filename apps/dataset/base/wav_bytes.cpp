#include "apps/dataset/base/wav_bytes.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include "aula/exception.h"

namespace aula {

namespace {

static_assert(std::endian::native == std::endian::little, "WAV files are little-endian");

constexpr std::size_t kHeader = 58;
constexpr std::uint16_t kFloat = 3;  // WAVE_FORMAT_IEEE_FLOAT

template <typename T>
void put(std::string& bytes, T number) {
    bytes.append(reinterpret_cast<const char*>(&number), sizeof(number));
}

/// Header with the chunks fmt and fact, which formats other than PCM need.
std::string header(std::size_t channels, std::size_t samples, int sample_rate_hz) {
    const auto frame = static_cast<std::uint32_t>(channels * sizeof(float));
    const auto data = static_cast<std::uint32_t>(samples * frame);
    std::string bytes = "RIFF";
    put(bytes, static_cast<std::uint32_t>(kHeader - 8 + data));
    bytes += "WAVEfmt ";
    put(bytes, std::uint32_t{18});
    put(bytes, kFloat);
    put(bytes, static_cast<std::uint16_t>(channels));
    put(bytes, static_cast<std::uint32_t>(sample_rate_hz));
    put(bytes, static_cast<std::uint32_t>(sample_rate_hz) * frame);
    put(bytes, static_cast<std::uint16_t>(frame));
    put(bytes, std::uint16_t{8 * sizeof(float)});
    put(bytes, std::uint16_t{0});
    bytes += "fact";
    put(bytes, std::uint32_t{4});
    put(bytes, static_cast<std::uint32_t>(samples));
    bytes += "data";
    put(bytes, data);
    return bytes;
}

float sample(std::string_view bytes, std::size_t at) {
    float value = 0;
    std::memcpy(&value, bytes.data() + at, sizeof(value));
    return value;
}

}  // namespace

std::string wav_bytes(const std::vector<std::vector<float>>& channels, int sample_rate_hz) {
    const std::size_t samples = channels[0].size();
    if (wav_length(kHeader + samples * channels.size() * sizeof(float), channels.size()) != samples)
        throw InputError("a response of " + std::to_string(channels.size()) + " channels and " +
                         std::to_string(samples) +
                         " samples is too large for WAV; expected less than 4 GiB");
    std::string bytes = header(channels.size(), samples, sample_rate_hz);
    bytes.reserve(bytes.size() + samples * channels.size() * sizeof(float));
    for (std::size_t i = 0; i < samples; ++i)
        for (const auto& channel : channels) put(bytes, channel[i]);
    return bytes;
}

std::uint64_t wav_length(std::uint64_t size, std::size_t channels) {
    constexpr std::uint64_t kLargest = std::numeric_limits<std::uint32_t>::max();
    const std::uint64_t frame = channels * sizeof(float);
    if (size < kHeader || size > kLargest || (size - kHeader) % frame != 0) return 0;
    return (size - kHeader) / frame;
}

bool is_wav(std::string_view bytes, std::size_t channels, std::uint64_t samples,
            int sample_rate_hz) {
    if (wav_length(bytes.size(), channels) != samples ||
        !bytes.starts_with(header(channels, samples, sample_rate_hz)))
        return false;
    for (std::size_t at = kHeader; at < bytes.size(); at += sizeof(float))
        if (!std::isfinite(sample(bytes, at))) return false;
    return true;
}

std::vector<std::vector<float>> wav_channels(std::string_view bytes, std::size_t channels) {
    const std::uint64_t samples = wav_length(bytes.size(), channels);
    std::vector<std::vector<float>> read(channels, std::vector<float>(samples));
    std::size_t at = kHeader;
    for (std::size_t i = 0; i < samples; ++i)
        for (auto& channel : read) {
            channel[i] = sample(bytes, at);
            at += sizeof(float);
        }
    return read;
}

}  // namespace aula
