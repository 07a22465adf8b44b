#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "aula/audio/realtime.h"

namespace aula {

inline constexpr int kHighestAmbisonicOrder = 3;

/// Number of channels of a full-sphere ambisonic field: 1, 4, 9, 16.
constexpr std::size_t ambisonic_channels(int order) {
    return static_cast<std::size_t>((order + 1) * (order + 1));
}
inline constexpr std::size_t kMaxAmbisonicChannels = ambisonic_channels(kHighestAmbisonicOrder);

/// Order of the harmonic of a channel (ACN): 0, 1 1 1, 2 2 2 2 2, ...
constexpr int order_of_channel(std::size_t channel) {
    int order = 0;
    while (ambisonic_channels(order) <= channel) ++order;
    return order;
}

/// A direction of sound: a unit vector (x front, y left, z up) times its distinctness. The
/// distinctness is 1 for sound from afar. It falls to 0 for sound that arises at the centre of the
/// head, which has no direction.
struct HeardDirection {
    std::array<float, 3> unit{1, 0, 0};
    float distinctness = 1;
};

/// Separates the product. Vectors of a length above 1 - 1e-5 are unit vectors, with rounding.
HeardDirection heard_direction(const std::array<float, 3>& direction) noexcept AULA_NONBLOCKING;

/// Gains that encode a plane wave from a direction: real spherical harmonics up to third order,
/// ACN, SN3D. Lower orders are prefixes. Orders above 0 are scaled by the distinctness.
std::array<float, kMaxAmbisonicChannels> encode_direction(
    const std::array<float, 3>& direction) noexcept AULA_NONBLOCKING;

/// Orientation of the head. Rows are the head's x (front), y (left) and z (up) axes in world axes:
/// head = rotation * world.
using HeadRotation = std::array<std::array<float, 3>, 3>;
inline constexpr HeadRotation kNoRotation{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

/// Transforms a direction from world axes to head axes.
std::array<float, 3> in_head_axes(const HeadRotation& head,
                                  const std::array<float, 3>& direction) noexcept AULA_NONBLOCKING;

/// Rotates an ambisonic field from world axes to head axes. The rotation matrix is interpolated
/// linearly to a new orientation, sample by sample, over `glide_samples`, which avoids clicks. The
/// first orientation takes effect immediately. [audio thread, except the constructor]
class FieldRotation {
 public:
    FieldRotation(int order, std::size_t glide_samples);

    /// Starts the interpolation to a new orientation at the next sample.
    void turn_to(const HeadRotation& head) noexcept AULA_NONBLOCKING;

    /// Rotates a block of ambisonic_channels(order) channels in place.
    void process(std::span<float* const> channels, std::size_t samples) noexcept AULA_NONBLOCKING;

 private:
    /// Block-diagonal rotation matrix of the harmonics: a square block [row][column] per order.
    using Matrix = std::array<float, 1 + 9 + 25 + 49>;

    /// Factors of the recursion for an element of a block.
    struct Factors {
        float u, v, w;
    };

    void rotate_harmonics(const HeadRotation& head, Matrix& matrix) const noexcept AULA_NONBLOCKING;
    void process_chunk(std::span<float* const> channels, std::size_t offset,
                       std::size_t samples) noexcept AULA_NONBLOCKING;

    int order_;
    std::size_t glide_samples_;
    std::vector<Factors> factors_;  ///< for orders from 2 on, in the layout of Matrix
    HeadRotation head_{};
    bool started_ = false;
    std::size_t remaining_ = 0;  ///< samples until the target is reached
    Matrix value_{};
    Matrix target_{};
    Matrix step_{};  ///< per sample
};

}  // namespace aula
