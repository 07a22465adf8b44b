#include "apps/dataset/base/wav_bytes.h"

#include <bit>
#include <cstdint>
#include <cstring>

#include "aula/exception.h"

namespace aula {

namespace {

static_assert(std::endian::native == std::endian::little, "WAV files are little-endian");

constexpr std::size_t kHeader = 58;
constexpr std::size_t kChannelsAt = 22;
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

}  // namespace

std::string wav_bytes(const std::vector<std::vector<float>>& channels, int sample_rate_hz) {
    const std::size_t samples = channels[0].size();
    std::string bytes = header(channels.size(), samples, sample_rate_hz);
    bytes.reserve(bytes.size() + samples * channels.size() * sizeof(float));
    for (std::size_t i = 0; i < samples; ++i)
        for (const auto& channel : channels) put(bytes, channel[i]);
    return bytes;
}

std::vector<std::vector<float>> wav_channels(std::string_view bytes) {
    std::uint16_t count = 0;
    if (bytes.size() >= kHeader) std::memcpy(&count, bytes.data() + kChannelsAt, sizeof(count));
    if (count == 0) throw InputError("a response is damaged; expected a WAV file");
    std::vector<std::vector<float>> channels(count);
    const std::size_t samples = wav_length(bytes.size(), count);
    const char* next = bytes.data() + kHeader;
    for (auto& channel : channels) channel.resize(samples);
    for (std::size_t i = 0; i < samples; ++i)
        for (auto& channel : channels) {
            std::memcpy(&channel[i], next, sizeof(float));
            next += sizeof(float);
        }
    return channels;
}

std::size_t wav_length(std::size_t size, std::size_t channels) {
    return (size - kHeader) / (channels * sizeof(float));
}

}  // namespace aula
