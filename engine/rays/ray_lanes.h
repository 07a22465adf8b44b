#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "engine/scene/scene.h"

namespace aula {

inline constexpr std::uint32_t kNoTriangle = std::numeric_limits<std::uint32_t>::max();

/// Rays side by side, as vector units take them.
inline constexpr std::size_t kLanes = 128;

/// Lanes that are computed where `count` are in use: whole vectors. What the others hold is left
/// from before or zero, may be no number, and never counts nor is an index.
constexpr std::size_t padded_lanes(std::size_t count) {
    constexpr std::size_t kVector = 16;
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

/// A Hit a lane.
struct HitLanes {
    alignas(64) std::array<std::uint32_t, kLanes> triangle{};
    alignas(64) std::array<float, kLanes> distance_m{};
    alignas(64) std::array<float, kLanes> u{};
    alignas(64) std::array<float, kLanes> v{};
};

}  // namespace aula
