#pragma once

#include "aula/engine/vec3.h"

namespace aula {

/// Moments of directions of arrival up to degree 2: sums over arrivals of energy times the unit
/// direction u, to where the sound comes from, and times its products. World axes. All are 0 in a
/// diffuse field.
struct DirectionMoments {
    /// The active intensity vector, reversed: the sum of u. Divided by the sum of the energies, its
    /// length is 1 if all sound comes from one direction and 0 in a diffuse field.
    Vec3 intensity{0};
    float xx = 0;  ///< the sum of u.x^2 - 1/3; that of u.z^2 - 1/3 is -(xx + yy)
    float yy = 0;  ///< the sum of u.y^2 - 1/3
    float xy = 0;  ///< the sum of u.x u.y
    float yz = 0;  ///< the sum of u.y u.z
    float zx = 0;  ///< the sum of u.z u.x

    /// Those of an arrival of energy 1. A shorter `u` counts as partly diffuse.
    static constexpr DirectionMoments of(const Vec3& u) {
        const float third = (u.x * u.x + u.y * u.y + u.z * u.z) / 3;
        return {u, u.x * u.x - third, u.y * u.y - third, u.x * u.y, u.y * u.z, u.z * u.x};
    }

    /// The sum of (u.a)^2 - 1/3 for a unit vector a.
    constexpr float along(const Vec3& a) const {
        return xx * (a.x * a.x - a.z * a.z) + yy * (a.y * a.y - a.z * a.z) +
               2 * (xy * a.x * a.y + yz * a.y * a.z + zx * a.z * a.x);
    }

    /// Adds those of other arrivals.
    constexpr DirectionMoments& operator+=(const DirectionMoments& o) {
        intensity += o.intensity;
        xx += o.xx;
        yy += o.yy;
        xy += o.xy;
        yz += o.yz;
        zx += o.zx;
        return *this;
    }
    /// Multiplies by an energy.
    constexpr DirectionMoments& operator*=(float k) {
        intensity *= k;
        xx *= k;
        yy *= k;
        xy *= k;
        yz *= k;
        zx *= k;
        return *this;
    }
    /// The quotient by an energy: those of unit energy.
    friend constexpr DirectionMoments operator/(const DirectionMoments& a, float k) {
        return {a.intensity / k, a.xx / k, a.yy / k, a.xy / k, a.yz / k, a.zx / k};
    }
    /// Those of the arrivals of both.
    friend constexpr DirectionMoments operator+(DirectionMoments a, const DirectionMoments& b) {
        return a += b;
    }
    /// The product with an energy.
    friend constexpr DirectionMoments operator*(DirectionMoments a, float k) { return a *= k; }
    /// True if all are equal.
    friend bool operator==(const DirectionMoments&, const DirectionMoments&) = default;
};

}  // namespace aula
