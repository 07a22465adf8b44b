#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/mat3x3.hpp>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/bands.h"
#include "engine/base/vec3.h"
#include "engine/scene/medium.h"

namespace aula {

/// Position in metres (right-handed, z up) and orientation in radians: yaw 0 looks along +x and
/// turns left, pitch turns up, roll turns the right ear down.
struct Pose {
    Vec3 position{0};
    float yaw_rad = 0;
    float pitch_rad = 0;
    float roll_rad = 0;

    /// Rotation from the local frame (x front, y left, z up) to the world.
    glm::mat3 rotation() const;
};

/// A rigid motion of an object: its local vertices are rotated about the local origin, then moved.
struct RigidTransform {
    glm::mat3 rotation{1};  ///< orthonormal, determinant 1
    Vec3 translation{0};

    RigidTransform() = default;
    RigidTransform(const glm::mat3& rotation_in, const Vec3& translation_in)
        : rotation(rotation_in), translation(translation_in) {}
    explicit RigidTransform(const Pose& pose)
        : rotation(pose.rotation()), translation(pose.position) {}

    friend bool operator==(const RigidTransform&, const RigidTransform&) = default;
};

/// A walk: poses linear in time between points, the first before the first point, the last after
/// the last; repeated when `loop`. Never empty.
struct Trajectory {
    struct Keyframe {
        double time_s = 0;
        Pose pose;
    };
    std::vector<Keyframe> points;
    bool loop = false;

    Pose at(double time_s) const;
    double duration_s() const { return points.back().time_s; }
};

/// A surface: the share of energy that is absorbed, and the share of the reflected energy that is
/// scattered (Lambert), each 0..1 for every octave band.
struct Material {
    std::string name;
    Bands absorption = Bands::filled(0.1F);
    Bands scattering = Bands::filled(0.1F);
};

/// A piece of geometry: triangles, each with the index of its material in Scene::materials. Its
/// vertices are local: scale and up axis are applied, path and translation are not.
struct Object {
    std::string name;
    std::vector<Vec3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<std::uint32_t> triangle_materials;
    std::vector<std::filesystem::path> files;  ///< that a mesh was read from
    Vec3 translation{0};
    std::optional<Trajectory> path;
    bool movable = false;  ///< transforms may be pushed; an object with a path is movable, too

    bool moves() const { return movable || path.has_value(); }

    /// The path's transform at a time; none without a path.
    RigidTransform transform_at(double time_s) const {
        return path ? RigidTransform(path->at(time_s)) : RigidTransform{};
    }

    /// Vertices in the world under a transform: rotation about the local origin, then the
    /// transform's translation and the object's.
    std::vector<Vec3> world_vertices(const RigidTransform& transform) const;

    /// Vertices in the world at a time of the object's path.
    std::vector<Vec3> world_vertices(double time_s) const {
        return world_vertices(transform_at(time_s));
    }
};

/// A box along the axes.
struct Bounds {
    Vec3 min{std::numeric_limits<float>::infinity()};
    Vec3 max{-std::numeric_limits<float>::infinity()};

    void add(const Vec3& point);
    bool contains(const Vec3& point) const;
    /// The farthest that two points within can be apart.
    float diagonal_m() const;
};

/// The bounds of all geometry and, of moving objects, of their boxes wherever their paths' points
/// take them: somewhat more than the vertices need where a path turns.
Bounds geometry_bounds(const std::vector<Object>& objects);

/// A sound source that radiates alike in all directions.
struct Source {
    enum class Signal { file, impulse, noise };

    std::string name;
    Vec3 position{0};
    Signal signal = Signal::impulse;
    std::filesystem::path signal_file;  ///< absolute or relative to the working directory
    float gain_db = 0;
    bool loop = false;
    std::optional<Trajectory> path;

    Vec3 position_at(double time_s) const { return path ? path->at(time_s).position : position; }
};

struct Listener {
    Pose pose;
    std::optional<Trajectory> path;

    Pose pose_at(double time_s) const { return path ? path->at(time_s) : pose; }
};

enum class Estimator { pt, dpc_published, dpc, patch };

/// The name that scene files and the command line use: "pt", "dpc-published", "dpc", "patch".
const char* estimator_name(Estimator estimator);
std::optional<Estimator> estimator_from_name(const std::string& name);

/// How to simulate: a scene's "simulation" object, each value with its default.
struct Simulation {
    /// A source's rays of one frame have to fit in memory with all that they find.
    static constexpr int kMostRays = 200'000;
    /// The time that a frame's image sources take grows with the square of their order.
    static constexpr int kHighestSpecularOrder = 100;

    Estimator estimator = Estimator::patch;
    int rays = 1000;               ///< per source and frame, at most kMostRays
    int order = 0;                 ///< highest reflection order; 0: no limit
    int specular_order = 3;        ///< highest order of the image sources
    bool specular = true;          ///< false leaves purely specular paths out
    bool direct = true;            ///< false leaves the direct sound out
    float response_time_s = 0.5F;  ///< tau
    float patch_size_m = 0.5F;     ///< lambda
    float listener_radius_m = 0.5F;
    float frame_rate_hz = 30;
    std::optional<float> ir_length_s;  ///< from the room (at most 4 s) where absent
    std::uint64_t seed = 1;
    std::optional<int> threads;  ///< all processors but one, at least 1, where absent
    int memory_mb = 256;         ///< for the caches

    friend bool operator==(const Simulation&, const Simulation&) = default;

    /// The window in frames: F = max(1, round(tau * frame rate)).
    int window_frames() const;
};

/// All that a scene file says. A value: copy it, change it, build one by hand.
struct Scene {
    std::vector<Object> objects;
    std::vector<Material> materials;
    Medium medium;
    std::vector<Source> sources;
    Listener listener;
    Simulation simulation;

    /// Adds an object of one material, one of `materials` or of the library by its name. Its index.
    /// Throws Error if there is no such material.
    std::size_t add_object(std::vector<Vec3> vertices,
                           std::vector<std::array<std::uint32_t, 3>> triangles,
                           const std::string& material, std::string name = {});

    /// The material of that name: of the scene or else of the library. Throws Error.
    Material find_material(const std::string& name) const;
};

}  // namespace aula
