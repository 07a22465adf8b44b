#include "audio/file/headphone_file.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "audio/dsp/resample.h"
#include "aula/audio/sound_file.h"
#include "aula/exception.h"

namespace aula {

namespace {

// The resampler's filter has a transition band of 0.09 of the Nyquist frequency at -120 dB: its
// impulse response rings for 87 samples of the lower rate on each side (Kaiser).
constexpr std::size_t kRinging = 88;

// -60 dB: what is cut off before the onset changes the gain by 0.01 dB.
constexpr float kOnset = 1e-3F;

/// The channels at another rate, with the same gain at each frequency. Time 0 of the file is kept
/// where its response begins with so much silence that the ringing of the resampler has room;
/// otherwise the ringing from -60 dB on comes first.
std::vector<std::vector<float>> at_rate(std::vector<std::vector<float>> channels, double from_hz,
                                        double to_hz) {
    if (from_hz == to_hz) return channels;
    const double ratio = to_hz / from_hz;
    const auto lead = static_cast<std::size_t>(
        std::ceil(static_cast<double>(kRinging) * std::max(1.0, 1 / ratio)));
    const auto zero = static_cast<std::size_t>(static_cast<double>(lead) * ratio);
    std::size_t begin = zero;
    for (std::vector<float>& channel : channels) {
        channel.insert(channel.begin(), lead, 0.0F);
        channel.insert(channel.end(), lead, 0.0F);
        channel = resample(channel, 1, from_hz, to_hz);
        for (float& sample : channel) sample /= static_cast<float>(ratio);
    }
    float largest = 0;
    for (const std::vector<float>& channel : channels)
        for (const float sample : channel) largest = std::max(largest, std::abs(sample));
    for (std::vector<float>& channel : channels) {
        const auto onset = std::find_if(channel.begin(), channel.end(), [&](float sample) {
            return std::abs(sample) >= kOnset * largest;
        });
        begin = std::min(begin, static_cast<std::size_t>(onset - channel.begin()));
    }
    for (std::vector<float>& channel : channels)
        channel.erase(channel.begin(), channel.begin() + static_cast<std::ptrdiff_t>(begin));
    return channels;
}

/// Samples of all channels up to the last one that is not 0.
std::size_t sounding_samples(const std::vector<std::vector<float>>& channels) {
    std::size_t samples = 0;
    for (const std::vector<float>& channel : channels) {
        const auto last =
            std::find_if(channel.rbegin(), channel.rend(), [](float x) { return x != 0; });
        samples = std::max(samples, static_cast<std::size_t>(channel.rend() - last));
    }
    return samples;
}

}  // namespace

std::shared_ptr<const HeadphoneFilter> read_headphones(const std::filesystem::path& file,
                                                       double sample_rate_hz) {
    SoundChannels sound = read_channels(file);
    const std::string name = file.string() + ": ";
    // A filter that is cut off, or has gaps, is another one.
    if (!sound.warnings.empty())
        throw InputError(sound.warnings.front() + "; expected a whole impulse response");
    if (sound.channels.size() > 2)
        throw InputError(name + "has " + std::to_string(sound.channels.size()) +
                         " channels; expected 1 for both ears, or 2 for left and right");
    const std::size_t samples = sounding_samples(sound.channels);
    if (samples == 0) throw InputError(name + "is silent; expected an impulse response");
    const double length_s = static_cast<double>(samples) / sound.sample_rate_hz;
    if (length_s > HeadphoneFilter::kLongest_s)
        throw InputError(name + "lasts " + std::to_string(length_s) +
                         " s; expected an impulse response of headphones, of at most 4 s");
    for (std::vector<float>& channel : sound.channels) channel.resize(samples);
    sound.channels = at_rate(std::move(sound.channels), sound.sample_rate_hz, sample_rate_hz);
    return std::make_shared<const HeadphoneFilter>(
        HeadphoneFilter{.ears = {sound.channels.front(), sound.channels.back()}});
}

}  // namespace aula
