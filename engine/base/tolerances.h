#pragma once

#include <numbers>

/// Lengths and angles below which places, planes and directions count as one. Each presupposes
/// others, as the assertions state.
namespace aula::tolerances {

/// Rounding of lengths and places in single precision, relative to them: some steps of 2^-23.
inline constexpr float kRounding = 4e-7F;

/// Height of a triangle over its longest side, relative to the side, below which rounding hides it:
/// the spacing of single precision is 2^-23 of a place or less.
inline constexpr double kNoHeight = 1e-7;

/// A point within this distance of a plane lies in it. Above the rounding of places up to 128 m
/// from the origin.
inline constexpr double kInPlane_m = 1e-5;

/// Offset of every point that represents a position on a surface, on its side: ray origins, and
/// the points that assign deposits, gather rays and area samples to patches. Segments are shortened
/// by as much where they begin and end at surfaces. A choice: a tenth of kSame_m, so that no point
/// passes a second surface, and well above the rounding of places.
inline constexpr float kOffset_m = 1e-4F;

/// Overlapping coplanar faces are this flat: a point on one of them is in front of the others.
inline constexpr float kFlat_m = kOffset_m / 8;

/// A point within this distance of a surface was placed on it: rounding to whole millimetres moves
/// a point by up to this distance along each axis.
inline constexpr double kOnSurface_m = 5e-4;

/// Places within this distance of each other are one: corners, lines and planes of a mesh, hits of
/// a ray, and a path and the edge that it touches. Rounding to whole millimetres moves a corner by
/// up to 0.87 mm.
inline constexpr double kSame_m = 1e-3;

/// Places that are each known within kSame_m are apart from here on. Corners that are rounded to
/// millimetres make faces that share a side overlap by less.
inline constexpr double kApart_m = 2e-3;

/// Faces whose normals differ by less are parts of one plane, if their corners are within kSame_m
/// of it. A choice: rounding to millimetres turns a face of 0.5 m by this angle.
inline constexpr double kCoplanar_rad = 0.1 * std::numbers::pi / 180;

/// Least cosine of two directions that count as one, such as the normal of a wall and an axis: that
/// of kCoplanar_rad, 1 - a^2 / 2.
inline constexpr float kAlongCosine = static_cast<float>(1 - kCoplanar_rad * kCoplanar_rad / 2);

/// Faces about an edge within this angle of each other are one, and a surface that bends by less at
/// an edge is flat. The diffracted field of a wedge that bends by this angle, in proportion to
/// sin(pi^2 / open angle), is 35 dB below that of a half plane.
inline constexpr double kOnFace_rad = std::numbers::pi / 180;

static_assert(kInPlane_m > 64.0 / (1 << 23), "rounding moves points off their planes");
static_assert(double{kFlat_m} > kInPlane_m, "faces that rounding makes uneven are not flat");
static_assert(kOffset_m > 2 * kFlat_m, "points on the lower of two coplanar faces are behind");
static_assert(kOffset_m > 100 * kRounding, "the offset is lost in the rounding of 100 m");
static_assert(kOnSurface_m > 2 * double{kOffset_m},
              "points off a surface are taken as placed on it");
static_assert(kOnSurface_m >= 0.5e-3 && kSame_m > 0.5e-3 * std::numbers::sqrt3,
              "coordinates of whole millimetres");
static_assert(kSame_m >= 2 * kOnSurface_m, "a point on a surface is moved out of a plane's reach");
static_assert(kApart_m >= 2 * kSame_m, "two places may each be off by kSame_m");
static_assert(kCoplanar_rad < kOnFace_rad, "an edge divides a plane");
static_assert(1 - kAlongCosine > 2 * kRounding, "rounding turns a wall out of its axis");

}  // namespace aula::tolerances
