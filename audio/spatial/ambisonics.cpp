#include "audio/spatial/ambisonics.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>

namespace aula {

namespace {

/// Samples rotated at a time.
constexpr std::size_t kChunk = 64;

/// Offset of an order's block in a matrix.
constexpr std::size_t block_start(int order) {
    std::size_t start = 0;
    for (int l = 0; l < order; ++l) start += static_cast<std::size_t>((2 * l + 1) * (2 * l + 1));
    return start;
}

/// Offset of element (m, n) in an order's block, m and n from -order to order.
constexpr std::size_t element(int order, int m, int n) {
    return static_cast<std::size_t>((m + order) * (2 * order + 1) + n + order);
}

}  // namespace

HeardDirection heard_direction(const std::array<float, 3>& direction) noexcept {
    constexpr float kUnitLength = 1 - 1e-5F;
    const float length = std::sqrt(direction[0] * direction[0] + direction[1] * direction[1] +
                                   direction[2] * direction[2]);
    if (length > kUnitLength) return {direction, 1};
    if (!(length > std::numeric_limits<float>::min())) return {.distinctness = 0};
    return {{direction[0] / length, direction[1] / length, direction[2] / length}, length};
}

std::array<float, kMaxAmbisonicChannels> encode_direction(
    const std::array<float, 3>& direction) noexcept {
    const HeardDirection heard = heard_direction(direction);
    const auto [x, y, z] = heard.unit;
    constexpr float kRoot3 = std::numbers::sqrt3_v<float>;
    constexpr float kRoot15 = 3.87298335F;
    constexpr float kRoot3by8 = 0.612372436F;
    constexpr float kRoot5by8 = 0.790569415F;
    std::array<float, kMaxAmbisonicChannels> gains{1,
                                                   y,
                                                   z,
                                                   x,
                                                   kRoot3 * x * y,
                                                   kRoot3 * y * z,
                                                   0.5F * (3 * z * z - 1),
                                                   kRoot3 * x * z,
                                                   0.5F * kRoot3 * (x * x - y * y),
                                                   kRoot5by8 * y * (3 * x * x - y * y),
                                                   kRoot15 * x * y * z,
                                                   kRoot3by8 * y * (5 * z * z - 1),
                                                   0.5F * z * (5 * z * z - 3),
                                                   kRoot3by8 * x * (5 * z * z - 1),
                                                   0.5F * kRoot15 * z * (x * x - y * y),
                                                   kRoot5by8 * x * (x * x - 3 * y * y)};
    for (std::size_t c = 1; c < gains.size(); ++c) gains[c] *= heard.distinctness;
    return gains;
}

std::array<float, 3> in_head_axes(const HeadRotation& head,
                                  const std::array<float, 3>& direction) noexcept {
    std::array<float, 3> rotated;
    for (std::size_t i = 0; i < 3; ++i) {
        rotated[i] =
            head[i][0] * direction[0] + head[i][1] * direction[1] + head[i][2] * direction[2];
    }
    return rotated;
}

// Ivanic and Ruedenberg, "Rotation Matrices for Real Spherical Harmonics. Direct Determination by
// Recursion", J. Phys. Chem. 100 (1996) 6342, with the corrections of 102 (1998) 9099. An order's
// block follows element by element from that of the order below and that of the first order:
//     R_mn = u U + v V + w W,
// where U, V and W are sums of products P and the factors u, v, w (table 1) depend on l, m, n only.
FieldRotation::FieldRotation(int order, std::size_t glide_samples)
    : order_(order), glide_samples_(glide_samples) {
    assert(order >= 0 && order <= kHighestAmbisonicOrder && glide_samples > 0);
    for (int l = 2; l <= order; ++l) {
        for (int m = -l; m <= l; ++m) {
            for (int n = -l; n <= l; ++n) {
                const double below =
                    std::abs(n) == l ? 2.0 * l * (2.0 * l - 1) : double(l + n) * double(l - n);
                const int a = std::abs(m);
                const double zero = m == 0 ? 1 : 0;
                const double u = std::sqrt(double(l + m) * double(l - m) / below);
                const double v = 0.5 * (1 - 2 * zero) *
                                 std::sqrt((1 + zero) * double(l + a - 1) * double(l + a) / below);
                const double w =
                    -0.5 * (1 - zero) * std::sqrt(double(l - a - 1) * double(l - a) / below);
                factors_.push_back(
                    {static_cast<float>(u), static_cast<float>(v), static_cast<float>(w)});
            }
        }
    }
}

void FieldRotation::rotate_harmonics(const HeadRotation& head, Matrix& matrix) const noexcept {
    matrix[0] = 1;
    if (order_ == 0) return;
    // The first order's channels are y, z, x.
    constexpr std::array<std::size_t, 3> kAxis{1, 2, 0};
    float* const first = matrix.data() + block_start(1);
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) first[3 * i + j] = head[kAxis[i]][kAxis[j]];
    }
    const Factors* factors = factors_.data();
    for (int l = 2; l <= order_; ++l) {
        const float* const lower = matrix.data() + block_start(l - 1);
        float* const block = matrix.data() + block_start(l);
        const auto p = [&](int i, int a, int n) {
            const auto r1 = [&](int j) { return first[element(1, i, j)]; };
            const auto r = [&](int b) { return lower[element(l - 1, a, b)]; };
            if (n == l) return r1(1) * r(l - 1) - r1(-1) * r(1 - l);
            if (n == -l) return r1(1) * r(1 - l) + r1(-1) * r(l - 1);
            return r1(0) * r(n);
        };
        constexpr float kRoot2 = std::numbers::sqrt2_v<float>;
        for (int m = -l; m <= l; ++m) {
            for (int n = -l; n <= l; ++n, ++factors) {
                float sum = 0;
                if (factors->u != 0) sum += factors->u * p(0, m, n);
                float v = 0;
                if (m == 0) {
                    v = p(1, 1, n) + p(-1, -1, n);
                } else if (m == 1) {
                    v = kRoot2 * p(1, 0, n);
                } else if (m == -1) {
                    v = kRoot2 * p(-1, 0, n);
                } else if (m > 0) {
                    v = p(1, m - 1, n) - p(-1, 1 - m, n);
                } else {
                    v = p(1, m + 1, n) + p(-1, -m - 1, n);
                }
                sum += factors->v * v;
                if (factors->w != 0) {
                    const float w = m > 0 ? p(1, m + 1, n) + p(-1, -m - 1, n)
                                          : p(1, m - 1, n) - p(-1, 1 - m, n);
                    sum += factors->w * w;
                }
                block[element(l, m, n)] = sum;
            }
        }
    }
}

void FieldRotation::turn_to(const HeadRotation& head) noexcept {
    if (started_ && head == head_) return;
    head_ = head;
    rotate_harmonics(head, target_);
    if (!started_) {
        started_ = true;
        value_ = target_;
        return;
    }
    remaining_ = glide_samples_;
    const float share = 1 / static_cast<float>(glide_samples_);
    for (std::size_t i = 0; i < value_.size(); ++i) step_[i] = share * (target_[i] - value_[i]);
}

void FieldRotation::process(std::span<float* const> channels, std::size_t samples) noexcept {
    assert(channels.size() == ambisonic_channels(order_));
    for (std::size_t done = 0; done < samples;) {
        // No chunk crosses the end of the interpolation.
        std::size_t count = std::min(kChunk, samples - done);
        if (remaining_ > 0) count = std::min(count, remaining_);
        process_chunk(channels, done, count);
        done += count;
    }
}

void FieldRotation::process_chunk(std::span<float* const> channels, std::size_t offset,
                                  std::size_t samples) noexcept {
    const bool gliding = remaining_ > 0;
    std::array<float, kChunk> time{};  // samples from the chunk's start to the end of each sample
    for (std::size_t n = 0; n < kChunk; ++n) time[n] = static_cast<float>(n + 1);
    for (int l = 1; l <= order_; ++l) {
        const auto width = static_cast<std::size_t>(2 * l + 1);
        const std::size_t first = ambisonic_channels(l - 1);
        std::array<std::array<float, kChunk>, 2 * kHighestAmbisonicOrder + 1> in{};
        for (std::size_t c = 0; c < width; ++c) {
            std::copy_n(channels[first + c] + offset, samples, in[c].begin());
        }
        for (std::size_t row = 0; row < width; ++row) {
            const std::size_t start = block_start(l) + row * width;
            std::array<float, kChunk> sum{};
            std::array<float, kChunk> slope{};
            for (std::size_t c = 0; c < width; ++c) {
                const float value = value_[start + c];
                for (std::size_t n = 0; n < kChunk; ++n) sum[n] += value * in[c][n];
                if (!gliding) continue;
                const float step = step_[start + c];
                for (std::size_t n = 0; n < kChunk; ++n) slope[n] += step * in[c][n];
            }
            if (gliding) {
                for (std::size_t n = 0; n < kChunk; ++n) sum[n] += time[n] * slope[n];
            }
            std::copy_n(sum.begin(), samples, channels[first + row] + offset);
        }
    }
    if (!gliding) return;
    remaining_ -= samples;
    for (std::size_t i = 0; i < value_.size(); ++i) {
        value_[i] += static_cast<float>(samples) * step_[i];
    }
    if (remaining_ == 0) value_ = target_;
}

}  // namespace aula
