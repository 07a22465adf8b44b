#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/mat3x3.hpp>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "aula/engine/bands.h"
#include "aula/engine/directivity.h"
#include "aula/engine/medium.h"
#include "aula/engine/simulation.h"
#include "aula/engine/vec3.h"

namespace aula {

/// A position and an orientation. The local axes of a pose are x to the front, y to the left and z
/// up. With all angles 0 they are parallel to the world axes.
struct Pose {
    Vec3 position{0};     ///< m, world axes
    float yaw_rad = 0;    ///< turn to the left; 0 looks along +x, pi/2 along +y
    float pitch_rad = 0;  ///< elevation of the view direction; positive is up
    float roll_rad = 0;   ///< turn about the view direction; positive lowers the right ear

    /// Rotation from the local axes to the world axes: roll first, then pitch, then yaw.
    glm::mat3 rotation() const;

    /// The pose of the same orientation at a position in the local axes, m.
    Pose at(const Vec3& local_position) const;
};

/// A rigid motion of an object: a rotation of its vertices about its local origin, then a
/// translation.
struct RigidTransform {
    glm::mat3 rotation{1};  ///< orthonormal, determinant 1; its columns are the rotated axes
    Vec3 translation{0};    ///< m, world axes; added to Object::translation

    /// No motion.
    RigidTransform() = default;
    /// Rotates by a matrix, then translates.
    RigidTransform(const glm::mat3& rotation_in, const Vec3& translation_in)
        : rotation(rotation_in), translation(translation_in) {}
    /// Rotates by the orientation of a pose, then translates by its position.
    explicit RigidTransform(const Pose& pose)
        : rotation(pose.rotation()), translation(pose.position) {}

    /// True if all elements are equal.
    friend bool operator==(const RigidTransform&, const RigidTransform&) = default;
};

/// Poses over time. Positions and angles are interpolated linearly between keyframes, angles as
/// plain numbers. They are constant before the first keyframe and after the last.
struct Trajectory {
    /// A pose and its time.
    struct Keyframe {
        double time_s = 0;  ///< since the start, >= 0
        Pose pose;          ///< the pose at that time
    };
    /// At least one keyframe, by ascending time. Two keyframes of the same time make a jump.
    std::vector<Keyframe> points;
    bool loop = false;  ///< true: restarts at time 0 when it reaches the last keyframe

    /// The pose at a time.
    Pose at(double time_s) const;
    /// The time of the last keyframe.
    double duration_s() const { return points.back().time_s; }
};

/// A surface material.
struct Material {
    /// Unique among the scene's materials. It hides a material of that name in the library.
    std::string name;
    Bands absorption = Bands::filled(0.1F);  ///< share of the incident energy not reflected, 0..1
    /// Share of the reflected energy that leaves diffusely, by Lambert's law, 0..1. The rest is
    /// reflected specularly.
    Bands scattering = Bands::filled(0.1F);
    /// Sound reduction index R of the wall, 0 to kHighestSoundReduction_db. The share 10^(-R/10) of
    /// the incident energy passes the wall. It is a part of `absorption`. Absent: opaque.
    std::optional<Bands> sound_reduction_db{};

    /// Highest sound reduction index, dB.
    static constexpr float kHighestSoundReduction_db = 120;

    /// The share tau of the incident energy that passes the wall, at most `absorption`; 0 if the
    /// material is opaque.
    Bands transmission() const;

    /// True if a wall transmits more than it absorbs in a band. The sound reduction index must be
    /// present.
    bool transmits_too_much(std::size_t band) const;

    /// True if all members are equal.
    friend bool operator==(const Material&, const Material&) = default;
};

/// A piece of geometry: a mesh of triangles that reflect on both sides. It moves as a whole.
struct Object {
    std::string name;  ///< unique in its scene, for messages; empty: none
    /// Corners in m, relative to the local origin. Rotations are about that origin.
    std::vector<Vec3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< [triangle] indices in `vertices`
    std::vector<std::uint32_t> triangle_materials;        ///< [triangle] index in Scene::materials
    std::vector<std::filesystem::path> files;  ///< files that a mesh was read from; else empty
    Vec3 translation{0};             ///< world position of the local origin without movement, m
    std::optional<Trajectory> path;  ///< movement; its positions are added to `translation`
    bool movable = false;            ///< true: accepts transforms; not needed with a `path`

    /// True if the object is movable or has a path.
    bool moves() const { return movable || path.has_value(); }

    /// The transform of the path at a time; the identity without a path.
    RigidTransform transform_at(double time_s) const {
        return path ? RigidTransform(path->at(time_s)) : RigidTransform{};
    }

    /// The vertices in world axes: rotated about the local origin, then moved by the translations
    /// of `transform` and object. An object that does not move is not rotated.
    std::vector<Vec3> world_vertices(const RigidTransform& transform) const;

    /// The vertices in world axes at a time on the object's path.
    std::vector<Vec3> world_vertices(double time_s) const {
        return world_vertices(transform_at(time_s));
    }
};

/// An axis-aligned box, m. It is empty until a point is added.
struct Bounds {
    Vec3 min{std::numeric_limits<float>::infinity()};   ///< lowest corner; +infinity if empty
    Vec3 max{-std::numeric_limits<float>::infinity()};  ///< highest corner; -infinity if empty

    /// Enlarges the box to contain a point.
    void add(const Vec3& point);
    /// Enlarges the box to contain all points.
    void add(std::span<const Vec3> points);
    /// True for a point in the box or on its surface.
    bool contains(const Vec3& point) const;
    /// The largest distance between two points of the box; infinite if it is empty.
    float diagonal_m() const;
};

/// The bounds of all geometry. For an object with a path they contain its box at all keyframes,
/// which is somewhat larger than its vertices where the path rotates.
Bounds geometry_bounds(const std::vector<Object>& objects);

/// A sound source. A sample of 1.0 of an omnidirectional source has the amplitude 1.0 at a distance
/// of 1 m in a free field. A directivity distributes the same power over the directions. An
/// Auralizer receives the signal from its caller and uses only name, pose, gain, directivity and,
/// by follow_paths(), the path.
struct Source {
    /// Kind of the signal.
    enum class Signal {
        file,     ///< a sound file
        impulse,  ///< one sample of 1 at time 0; every second if `loop`
        noise     ///< white noise of -20 dBFS RMS
    };

    std::string name;     ///< unique in its scene; seeds the noise of the source's reverberation
    Vec3 position{0};     ///< m, world axes; not used with a `path`
    float yaw_rad = 0;    ///< orientation as in Pose; not used with a `path`
    float pitch_rad = 0;  ///< orientation as in Pose; not used with a `path`
    float roll_rad = 0;   ///< orientation as in Pose; not used with a `path`
    Directivity directivity;                 ///< in the local axes of the pose
    std::filesystem::path directivity_file;  ///< file that it was read from; else empty
    Signal signal = Signal::impulse;         ///< what the source plays
    std::filesystem::path signal_file;  ///< sound file of Signal::file; a relative name is relative
                                        ///< to the working directory
    float gain_db = 0;                  ///< of the signal; -200 to 200 in scene files
    bool loop = false;                  ///< true: repeats the signal
    std::optional<Trajectory> path;     ///< movement, world axes
    /// Of a source that moves and turns with the listener, such as its mouth: the position in the
    /// listener's axes, m. Scene::attach_sources() sets pose and path accordingly.
    std::optional<Vec3> from_listener{};

    /// Sets position and orientation; a path remains.
    void set_pose(const Pose& pose) {
        position = pose.position;
        yaw_rad = pose.yaw_rad;
        pitch_rad = pose.pitch_rad;
        roll_rad = pose.roll_rad;
    }

    /// The pose at a time.
    Pose pose_at(double time_s) const {
        return path ? path->at(time_s) : Pose{position, yaw_rad, pitch_rad, roll_rad};
    }

    /// The position at a time.
    Vec3 position_at(double time_s) const { return path ? path->at(time_s).position : position; }
};

/// The head that hears a scene.
struct Listener {
    Pose pose;                       ///< world axes; not used with a `path`
    std::optional<Trajectory> path;  ///< movement, world axes

    /// The pose at a time.
    Pose pose_at(double time_s) const { return path ? path->at(time_s) : pose; }
};

/// Levels of speech and noise, in dB re 20 uPa in each octave band, for speech transmission
/// indices.
struct SpeechConditions {
    static constexpr float kHighestLevel_db = 200;  ///< of scene files; the lowest is its negative

    /// The octave levels of male speech by IEC 60268-16:2011 with a level in dB(A). 63 Hz is not
    /// used.
    static constexpr Bands male_speech_db(float level_dba) {
        constexpr Bands kRelative_db{{0, 2.9F, 2.9F, -0.8F, -6.8F, -12.8F, -18.8F, -24.8F}};
        return kRelative_db + Bands::filled(level_dba);
    }

    /// Speech at 1 m in free field on the axis of each source, as IEC 60268-16 has it at the mouth.
    /// The default is normal effort.
    Bands speech_db = male_speech_db(60);
    std::optional<Bands> noise_db{};  ///< at the receivers; absent: no noise

    /// True if all levels are equal.
    friend bool operator==(const SpeechConditions&, const SpeechConditions&) = default;
};

/// A room with its sources and its listener: the content of a scene file. A value type: copy it,
/// modify it or construct it without a file.
struct Scene {
    std::vector<Object> objects;      ///< all geometry; empty: a free field
    std::vector<Material> materials;  ///< materials that the triangles of `objects` refer to
    Medium medium;                    ///< the air
    std::vector<Source> sources;      ///< may be empty
    Listener listener;                ///< the listener
    Simulation simulation;            ///< the settings of the propagation
    SpeechConditions speech;          ///< for speech transmission indices

    /// Adds an object of one material. `material` is the name of one of `materials`, or of one of
    /// the library, which is then copied to `materials`. Indices in `triangles` refer to `vertices`
    /// and are not checked. Returns the index of the object in `objects`. Throws InputError if
    /// there is no such material.
    std::size_t add_object(std::vector<Vec3> vertices,
                           std::vector<std::array<std::uint32_t, 3>> triangles,
                           const std::string& material, std::string name = {});

    /// Gives the sources that are attached to the listener (Source::from_listener) its orientation
    /// and its path, if it has one. Loading a scene does it; a change of the listener needs it.
    void attach_sources();

    /// The material of that name in `materials` or else in the library. Throws InputError if there
    /// is none.
    Material find_material(const std::string& name) const;
};

}  // namespace aula
