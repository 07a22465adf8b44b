#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "aula/engine/scene.h"

namespace aula {

inline constexpr std::uint32_t kNoTriangle = std::numeric_limits<std::uint32_t>::max();

/// Number of rays in a structure of arrays for vector units.
inline constexpr std::size_t kLanes = 128;

/// Number of lanes that are computed when `count` are in use: whole vectors. The unused lanes hold
/// old values, zeros or NaN; they never affect results and are never used as indices.
constexpr std::size_t padded_lanes(std::size_t count) {
    constexpr std::size_t kVector = 16;  // floats of AVX-512
    static_assert(kLanes % kVector == 0);
    return (count + kVector - 1) / kVector * kVector;
}

struct LanePoints {
    alignas(64) std::array<float, kLanes> x{};
    alignas(64) std::array<float, kLanes> y{};
    alignas(64) std::array<float, kLanes> z{};

    Vec3 at(std::size_t i) const { return {x[i], y[i], z[i]}; }
    void set(std::size_t i, const Vec3& p) {
        x[i] = p.x;
        y[i] = p.y;
        z[i] = p.z;
    }
};

struct RayLanes {
    LanePoints origin;
    LanePoints direction;  ///< unit
    alignas(64) std::array<float, kLanes> max_m{};
};

/// One Hit per lane.
struct HitLanes {
    alignas(64) std::array<std::uint32_t, kLanes> triangle{};
    alignas(64) std::array<float, kLanes> distance_m{};
    alignas(64) std::array<float, kLanes> u{};
    alignas(64) std::array<float, kLanes> v{};
};

}  // namespace aula
