#pragma once

#include <cstddef>
#include <memory>
#include <span>

namespace aula {

/// Loudness after ITU-R BS.1770 and EBU R 128; kSilence_lufs where there is nothing to measure.
struct Loudness {
    static constexpr double kSilence_lufs = -200;

    double momentary_lufs = kSilence_lufs;   ///< of 0.4 s
    double short_term_lufs = kSilence_lufs;  ///< of 3 s
    double integrated_lufs = kSilence_lufs;  ///< gated, since the start
    double true_peak = 0;  ///< largest value between samples, too, since the last read()
};

/// Measures what is heard: one channel, or the two of a pair; of more only the first, which is the
/// pressure in ambisonics. Allocates now and then. [one thread]
class LoudnessMeter {
 public:
    LoudnessMeter(double sample_rate_hz, std::size_t channels);
    ~LoudnessMeter();

    /// Takes frames in, interleaved.
    void add(std::span<const float> interleaved);

    Loudness read();

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
