#pragma once

#include <cstddef>
#include <memory>
#include <span>

namespace aula {

/// Loudness according to ITU-R BS.1770 and EBU R 128; kSilence_lufs without a signal to measure.
struct Loudness {
    static constexpr double kSilence_lufs = -200;

    double momentary_lufs = kSilence_lufs;   ///< over 0.4 s
    double short_term_lufs = kSilence_lufs;  ///< over 3 s
    double integrated_lufs = kSilence_lufs;  ///< gated, since the start
    double true_peak = 0;  ///< largest interpolated magnitude since the last read(), full scale 1
};

/// Measures one or two channels; of more channels only the first, which in ambisonics is the
/// pressure. May allocate. [one thread]
class LoudnessMeter {
 public:
    LoudnessMeter(double sample_rate_hz, std::size_t channels);
    ~LoudnessMeter();

    /// Adds interleaved samples of all channels, [sample][channel].
    void add(std::span<const float> interleaved);

    /// The present values; resets the true peak.
    Loudness read();

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
