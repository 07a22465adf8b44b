#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <numbers>

#include "aula/engine/vec3.h"
#include "engine/base/mix64.h"

namespace aula {

/// Derives a seed from another one and the numbers that identify its purpose. Deterministic.
template <typename... Parts>
constexpr std::uint64_t derive_seed(std::uint64_t seed, Parts... parts) {
    ((seed = mix64(seed + 0x9e3779b97f4a7c15ULL * (static_cast<std::uint64_t>(parts) + 1))), ...);
    return seed;
}

/// Pseudorandom numbers (splitmix64). Each seed gives a separate stream.
class RandomStream {
 public:
    RandomStream() = default;
    explicit RandomStream(std::uint64_t seed) : state_(seed) {}

    std::uint64_t bits() { return mix64(state_ += 0x9e3779b97f4a7c15ULL); }

    /// Uniform in [0, 1).
    float uniform() { return to_unit(static_cast<std::uint32_t>(bits() >> 32)); }

    /// Two independent uniform numbers in [0, 1).
    std::array<float, 2> uniform_2d() {
        const std::uint64_t b = bits();
        return {to_unit(static_cast<std::uint32_t>(b >> 32)),
                to_unit(static_cast<std::uint32_t>(b))};
    }

    /// RandomStream(state()) continues the stream.
    std::uint64_t state() const { return state_; }

    static float to_unit(std::uint32_t bits) {
        // Via a signed integer, which all vector units can convert.
        return static_cast<float>(static_cast<std::int32_t>(bits >> 8)) * 0x1p-24F;
    }

 private:
    std::uint64_t state_ = 0;
};

/// Points of the two-dimensional Sobol sequence with a random Owen scrambling per seed (Burley
/// 2020, "Practical Hash-based Owen Scrambling").
class ScrambledSobol {
 public:
    explicit ScrambledSobol(std::uint64_t seed)
        : seed_x_(static_cast<std::uint32_t>(mix64(seed))),
          seed_y_(static_cast<std::uint32_t>(mix64(seed) >> 32)) {}

    std::array<float, 2> point(std::uint32_t index) const {
        // The first dimension is the van der Corput sequence, the reversed bits of the index: one
        // of two reversals cancels.
        return {RandomStream::to_unit(reverse(permute(index, seed_x_))),
                RandomStream::to_unit(reverse(permute(reverse(second(index)), seed_y_)))};
    }

 private:
    static constexpr std::uint32_t reverse(std::uint32_t x) {
        x = ((x >> 1) & 0x55555555U) | ((x & 0x55555555U) << 1);
        x = ((x >> 2) & 0x33333333U) | ((x & 0x33333333U) << 2);
        x = ((x >> 4) & 0x0f0f0f0fU) | ((x & 0x0f0f0f0fU) << 4);
        x = ((x >> 8) & 0x00ff00ffU) | ((x & 0x00ff00ffU) << 8);
        return (x >> 16) | (x << 16);
    }
    /// Flips each bit by a hash of the bits below it (Laine and Karras 2011).
    static constexpr std::uint32_t permute(std::uint32_t x, std::uint32_t seed) {
        x += seed;
        x ^= x * 0x6c50b47cU;
        x ^= x * 0xb82f1e52U;
        x ^= x * 0xc7afe638U;
        x ^= x * 0x8d22f6e6U;
        return x;
    }
    /// Second dimension of the Sobol sequence: direction numbers of the polynomial x + 1.
    static constexpr std::uint32_t second(std::uint32_t index) {
        std::uint32_t result = 0;
        for (std::uint32_t v = 1U << 31; index != 0; index >>= 1, v ^= v >> 1) {
            if (index & 1U) result ^= v;
        }
        return result;
    }

    std::uint32_t seed_x_;
    std::uint32_t seed_y_;
};

/// Cosine and sine of 2 pi u, u in [0, 1], with an error below 2e-7. Branch-free, so that compilers
/// can vectorise it.
struct Turn {
    float cosine = 1;
    float sine = 0;

    explicit Turn(float u) {
        // The nearest multiple of pi / 2 and the remainder x, |x| <= pi / 4.
        const auto quarter = static_cast<std::int32_t>(4 * u + 0.5F);
        const float x = (u - 0.25F * static_cast<float>(quarter)) * (2 * std::numbers::pi_v<float>);
        const float x2 = x * x;
        // Taylor series; the next terms are below 2e-9 and 3e-8.
        const float s =
            x + x * x2 * (-1.0F / 6 + x2 * (1.0F / 120 + x2 * (-1.0F / 5040 + x2 / 362880)));
        const float c = 1 + x2 * (-0.5F + x2 * (1.0F / 24 + x2 * (-1.0F / 720 + x2 / 40320)));
        const bool odd = (quarter & 1) != 0;
        cosine = odd ? s : c;
        sine = odd ? c : s;
        cosine = ((quarter + 1) & 2) != 0 ? -cosine : cosine;
        sine = (quarter & 2) != 0 ? -sine : sine;
    }
};

/// A unit vector, uniform on the sphere for uniform u.
inline Vec3 uniform_direction(const std::array<float, 2>& u) {
    const float z = 1 - 2 * u[0];
    const float r = std::sqrt(std::max(0.0F, 1 - z * z));
    const Turn phi(u[1]);
    return {r * phi.cosine, r * phi.sine, z};
}

/// A unit vector with density cos(theta) / pi about a unit normal (Lambert), for uniform u:
/// the normalised sum of the normal and a uniform unit vector.
inline Vec3 lambert_direction(const Vec3& normal, const std::array<float, 2>& u) {
    const Vec3 sum = normal + uniform_direction(u);
    const float length = glm::length(sum);
    return length > 1e-6F ? sum / length : normal;
}

/// The specular reflection of a direction at a surface with a unit normal.
inline Vec3 mirror(const Vec3& direction, const Vec3& normal) {
    return direction - 2 * glm::dot(direction, normal) * normal;
}

}  // namespace aula
