#pragma once

#include <aula.h>

#include <array>
#include <atomic>
#include <cstdint>

namespace aula::unity {

/// The newest matrix that one thread has stored, for another one.
class SharedMatrix {
 public:
    /// [one thread, wait-free]
    void store(const float (&matrix)[16]) noexcept;
    /// False if there is none. [any thread but the audio thread]
    bool load(float (&matrix)[16]) const noexcept;
    /// [no other call at the same time]
    void clear() noexcept { version_ = 0; }

 private:
    std::atomic<std::uint32_t> version_{0};  ///< 0: none; odd: is stored just now
    std::array<std::atomic<float>, 16> values_{};
};

/// What a spatializer knows of its source. The room renders it in the same mix step, on the same
/// thread.
class SourceSlot {
 public:
    /// Longest block. The engine's have at most this many samples.
    static constexpr int kMostSamples = 4096;

    /// Takes a share of the mean of some channels as the signal of the present block.
    /// [audio thread, wait-free]
    void put(const float* in, int samples, int channels, float share) noexcept;
    /// The signal of the present block, silent unless put() was called for it. Each block is taken
    /// once. [audio thread, wait-free]
    aula_signal take(int samples) noexcept;

    SharedMatrix matrix;
    std::atomic<float> gain_db{0};
    std::atomic<int> directivity{0};
    std::atomic<aula_source> number{0};  ///< in the room that plays; 0: none
    std::atomic<bool> is_used{false};    ///< by an instance of the effect

    // What the room was told last. [the thread that moves]
    aula_pose pose{};
    float told_gain_db = 0;
    int told_directivity = 0;

 private:
    int taken_ = 0;  ///< samples of the present block
    std::array<float, kMostSamples> samples_{};
};

}  // namespace aula::unity
