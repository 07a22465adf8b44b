#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace aula {

/// Start of the answer of the program that decodes sound files. If the verdict is `usable`, blocks
/// follow. Native byte order.
struct SoundHeader {
    enum class Verdict : std::uint32_t {
        usable,
        unknown_format,
        unreadable,
        wrong_rate,
        wrong_channels
    };

    static constexpr std::array<char, 8> kMagic{'A', 'U', 'L', 'A', 'S', 'N', 'D', '1'};
    static constexpr int kLowestRate_hz = 1000;
    static constexpr int kHighestRate_hz = 768'000;
    static constexpr int kMaxChannels = 64;  // ambisonics of order 7

    std::array<char, 8> magic = kMagic;
    Verdict verdict = Verdict::unreadable;
    std::int32_t sample_rate_hz = 0;
    std::int32_t channels = 0;
    std::uint32_t unused = 0;
    std::int64_t samples = 0;         ///< of each channel, as the file says; kUnknown: it does not
    std::uint64_t missing_bytes = 0;  ///< at the end, which the header of the file promises

    static constexpr std::int64_t kUnknown = INT64_MAX;

    /// `usable`, or what is wrong with rate and channels.
    Verdict verdict_of_format() const {
        if (sample_rate_hz < kLowestRate_hz || sample_rate_hz > kHighestRate_hz)
            return Verdict::wrong_rate;
        return channels < 1 || channels > kMaxChannels ? Verdict::wrong_channels : Verdict::usable;
    }
};

/// Start of a block of samples of all channels, interleaved, in single precision. The last block is
/// empty.
struct SoundBlock {
    static constexpr std::uint32_t kMaxSamples = 16384;  // fills the pipe: 64 KiB

    std::uint32_t samples = 0;  ///< a multiple of the channels
    std::uint32_t damaged = 0;  ///< of the last block; 1: the file cannot be read to its end
};

}  // namespace aula
