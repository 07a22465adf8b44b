#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "aula/audio/realtime.h"

namespace aula {

/// Headphone equalisation at one sample rate: a filter for each ear (left, right), of one length
/// from 1 on. Its samples are factors: {1} for both ears changes nothing. Immutable; may be shared
/// between threads.
struct HeadphoneFilter {
    /// The longest response that is read.
    static constexpr double kLongest_s = 4;

    std::array<std::vector<float>, 2> ears;

    std::size_t taps() const { return ears[0].size(); }
};

/// Convolves binaural sound with a headphone filter, without latency.
class HeadphoneEqualizer {
 public:
    /// `block`: the largest number of samples of a call.
    HeadphoneEqualizer(const HeadphoneFilter& filter, int block);
    ~HeadphoneEqualizer();
    HeadphoneEqualizer(HeadphoneEqualizer&&) noexcept;
    HeadphoneEqualizer& operator=(HeadphoneEqualizer&&) noexcept;

    /// Replaces the sound of both ears. [audio thread, wait-free]
    void process(std::span<float* const> ears, int samples) noexcept AULA_NONBLOCKING;

 private:
    class Ear;
    std::vector<std::unique_ptr<Ear>> ears_;
};

/// Convolves a binaural impulse response, [ear][sample], which becomes longer by
/// HeadphoneFilter::taps() - 1 samples.
void equalize(const HeadphoneFilter& filter, std::vector<std::vector<float>>& response);

}  // namespace aula
