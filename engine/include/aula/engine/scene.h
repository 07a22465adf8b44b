#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/mat3x3.hpp>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "aula/engine/bands.h"
#include "aula/engine/medium.h"
#include "aula/engine/vec3.h"

namespace aula {

/// Position in metres (right-handed, z up) and orientation in radians: yaw 0 is along +x and
/// increases to the left, positive pitch is up, positive roll lowers the right ear.
struct Pose {
    Vec3 position{0};
    float yaw_rad = 0;
    float pitch_rad = 0;
    float roll_rad = 0;

    /// Rotation from the local frame (x front, y left, z up) to the world.
    glm::mat3 rotation() const;
};

/// A rigid motion of an object: rotation of the local vertices about the local origin, then
/// translation.
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

/// Poses over time: linear between keyframes, constant before the first and after the last, and
/// repeated if `loop`. Never empty.
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

/// A surface material: the share of energy that is absorbed, and the share of the reflected energy
/// that is scattered (Lambert), each 0..1 for every octave band.
struct Material {
    std::string name;
    Bands absorption = Bands::filled(0.1F);
    Bands scattering = Bands::filled(0.1F);
};

/// A piece of geometry: triangles, each with the index of its material in Scene::materials. The
/// vertices are local: scale and up axis are applied, path and translation are not.
struct Object {
    std::string name;
    std::vector<Vec3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<std::uint32_t> triangle_materials;
    std::vector<std::filesystem::path> files;  ///< from which a mesh was read
    Vec3 translation{0};
    std::optional<Trajectory> path;
    bool movable = false;  ///< transforms may be set; an object with a path is movable, too

    bool moves() const { return movable || path.has_value(); }

    /// The path's transform at a time; the identity without a path.
    RigidTransform transform_at(double time_s) const {
        return path ? RigidTransform(path->at(time_s)) : RigidTransform{};
    }

    /// World vertices under a transform: rotation about the local origin, then the translations of
    /// transform and object.
    std::vector<Vec3> world_vertices(const RigidTransform& transform) const;

    /// World vertices at a time of the object's path.
    std::vector<Vec3> world_vertices(double time_s) const {
        return world_vertices(transform_at(time_s));
    }
};

/// An axis-aligned box.
struct Bounds {
    Vec3 min{std::numeric_limits<float>::infinity()};
    Vec3 max{-std::numeric_limits<float>::infinity()};

    void add(const Vec3& point);
    bool contains(const Vec3& point) const;
    /// The largest distance between two points of the box.
    float diagonal_m() const;
};

/// The bounds of all geometry. The bounds of a moving object are those of its box at all keyframes,
/// somewhat larger than those of its vertices where a path rotates.
Bounds geometry_bounds(const std::vector<Object>& objects);

/// An omnidirectional sound source.
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

/// The name in scene files and on the command line: "pt", "dpc-published", "dpc", "patch".
const char* estimator_name(Estimator estimator);
std::optional<Estimator> estimator_from_name(const std::string& name);

/// The simulation settings: a scene's "simulation" object, each value with its default.
struct Simulation {
    /// A source's rays of one frame and their results have to fit in memory.
    static constexpr int kMostRays = 200'000;
    /// The time for a frame's image sources increases with the square of their order.
    static constexpr int kHighestSpecularOrder = 100;

    Estimator estimator = Estimator::patch;
    int rays = 1000;               ///< per source and frame, at most kMostRays
    int order = 0;                 ///< highest reflection order; 0: no limit
    int specular_order = 3;        ///< highest order of the image sources
    bool specular = true;          ///< false omits purely specular paths
    bool direct = true;            ///< false omits the direct sound
    float response_time_s = 0.5F;  ///< tau
    float patch_size_m = 0.5F;     ///< lambda
    float listener_radius_m = 0.5F;
    float frame_rate_hz = 30;
    std::optional<float> ir_length_s;  ///< if absent: from the room, at most 4 s
    std::uint64_t seed = 1;
    std::optional<int> threads;  ///< if absent: all processors but one, at least 1
    int memory_mb = 256;         ///< for the caches

    friend bool operator==(const Simulation&, const Simulation&) = default;

    /// The window in frames: F = max(1, round(tau * frame rate)).
    int window_frames() const;
};

/// The content of a scene file. A value type: copy it, modify it or construct it without a file.
struct Scene {
    std::vector<Object> objects;
    std::vector<Material> materials;
    Medium medium;
    std::vector<Source> sources;
    Listener listener;
    Simulation simulation;

    /// Adds an object of one material, which is one of `materials` or, by name, of the library.
    /// Returns the object's index. Throws InputError if there is no such material.
    std::size_t add_object(std::vector<Vec3> vertices,
                           std::vector<std::array<std::uint32_t, 3>> triangles,
                           const std::string& material, std::string name = {});

    /// The material of that name in the scene or else in the library. Throws InputError.
    Material find_material(const std::string& name) const;
};

}  // namespace aula
