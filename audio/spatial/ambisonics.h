#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "audio/base/realtime.h"

namespace aula {

inline constexpr int kHighestAmbisonicOrder = 3;

/// Channels of a full-sphere ambisonic field of an order: 1, 4, 9, 16.
constexpr std::size_t ambisonic_channels(int order) {
    return static_cast<std::size_t>((order + 1) * (order + 1));
}
inline constexpr std::size_t kMostAmbisonicChannels = ambisonic_channels(kHighestAmbisonicOrder);

/// Order of the harmonic behind a channel number (ACN): 0, 1 1 1, 2 2 2 2 2, ...
constexpr int order_of_channel(std::size_t channel) {
    int order = 0;
    while (ambisonic_channels(order) <= channel) ++order;
    return order;
}

/// Gains that encode a plane wave from a unit direction (x front, y left, z up): real spherical
/// harmonics up to third order, ACN, SN3D. A prefix of them is a lower order's.
std::array<float, kMostAmbisonicChannels> encode_direction(
    const std::array<float, 3>& direction) noexcept AULA_NONBLOCKING;

/// Orientation of the head: rows are the head's x (front), y (left), z (up) axes in world axes, so
/// that head = rotation * world.
using HeadRotation = std::array<std::array<float, 3>, 3>;
inline constexpr HeadRotation kNoRotation{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

/// A direction in head axes.
std::array<float, 3> in_head_axes(const HeadRotation& head,
                                  const std::array<float, 3>& direction) noexcept AULA_NONBLOCKING;

/// Turns an ambisonic field from world axes into head axes. A new orientation is moved to in a
/// straight line, sample by sample, over a set time: as short as to follow at once, long enough not
/// to click. The first is taken at once. [audio thread, but for the constructor]
class FieldRotation {
 public:
    FieldRotation(int order, std::size_t glide_samples);

    /// Where to turn to from the next sample on.
    void turn_to(const HeadRotation& head) noexcept AULA_NONBLOCKING;

    /// Turns a block in place; as many channels as the order has.
    void process(std::span<float* const> channels, std::size_t samples) noexcept AULA_NONBLOCKING;

 private:
    /// The rotation of harmonics, one square block [row][column] for each order, one after another.
    using Matrix = std::array<float, 1 + 9 + 25 + 49>;

    /// Factors of the recursion for one element of a block.
    struct Factors {
        float u, v, w;
    };

    void rotate_harmonics(const HeadRotation& head, Matrix& matrix) const noexcept AULA_NONBLOCKING;
    void process_chunk(std::span<float* const> channels, std::size_t offset,
                       std::size_t samples) noexcept AULA_NONBLOCKING;

    int order_;
    std::size_t glide_samples_;
    std::vector<Factors> factors_;  ///< of the orders from 2 on, as in Matrix
    HeadRotation head_{};
    bool started_ = false;
    std::size_t remaining_ = 0;  ///< samples until the target is reached
    Matrix value_{};
    Matrix target_{};
    Matrix step_{};  ///< per sample
};

}  // namespace aula
