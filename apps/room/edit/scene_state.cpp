#include "apps/room/edit/scene_state.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <numbers>
#include <optional>
#include <type_traits>
#include <vector>

#include "apps/room/auralizer/command_checks.h"
#include "aula/exception.h"
#include "engine/scene/scene_values.h"
#include "process/files.h"

namespace aula {

namespace {

constexpr std::string_view kHeader = "aula scene 4\n";

/// Directions by which directivities are compared: a spiral over the sphere with equal areas.
std::vector<Vec3> probe_directions() {
    constexpr std::size_t kCount = 64;
    std::vector<Vec3> directions;
    for (std::size_t i = 0; i < kCount; ++i) {
        const double z = 1 - (2 * static_cast<double>(i) + 1) / double{kCount};
        const double azimuth_rad = static_cast<double>(i) * std::numbers::pi * (3 - std::sqrt(5.0));
        const double radius = std::sqrt(1 - z * z);
        directions.emplace_back(radius * std::cos(azimuth_rad), radius * std::sin(azimuth_rad), z);
    }
    return directions;
}

std::vector<Bands> probe(const Directivity& directivity) {
    std::vector<Bands> factors;
    for (const Vec3& direction : probe_directions())
        factors.push_back(directivity.factor(direction));
    return factors;
}

class Writer {
 public:
    static constexpr bool kReads = false;

    template <typename T>
    void number(const T& x) {
        static_assert(std::is_arithmetic_v<T>);
        bytes_.append(reinterpret_cast<const char*>(&x), sizeof(x));
    }
    std::string take() { return std::move(bytes_); }

 private:
    std::string bytes_{kHeader};
};

class Reader {
 public:
    static constexpr bool kReads = true;

    explicit Reader(std::string_view bytes) : rest_(bytes) {
        if (!rest_.starts_with(kHeader))
            throw InputError("the state of a scene is not of this version of Aula");
        rest_.remove_prefix(kHeader.size());
    }

    template <typename T>
    void number(T& x) {
        static_assert(std::is_arithmetic_v<T>);
        if (rest_.size() < sizeof(x)) throw InputError("the state of a scene is incomplete");
        std::memcpy(&x, rest_.data(), sizeof(x));
        rest_.remove_prefix(sizeof(x));
    }
    std::size_t left() const { return rest_.size(); }

 private:
    std::string_view rest_;
};

// One overload for each type both writes and reads it: `archive` is a Writer with constant values
// or a Reader.

template <typename T, typename Plain>
concept Is = std::is_same_v<std::remove_cvref_t<T>, Plain>;

template <typename T>
concept Number = std::is_arithmetic_v<std::remove_cvref_t<T>> && !Is<T, bool>;

template <typename Archive, Number T>
void transfer(Archive& archive, T& x) {
    archive.number(x);
}

template <typename Archive, Is<bool> T>
void transfer(Archive& archive, T& flag) {
    std::uint8_t byte = flag ? 1 : 0;
    archive.number(byte);
    if constexpr (Archive::kReads) flag = byte != 0;
}

/// Several values, one after another.
template <typename Archive>
void transfer_all(Archive& archive, auto&... values) {
    (transfer(archive, values), ...);
}

template <typename Archive>
void transfer_enum(Archive& archive, auto& value, int last) {
    auto number = static_cast<std::int32_t>(value);
    archive.number(number);
    if constexpr (Archive::kReads) {
        if (number < 0 || number > last) throw InputError("the state of a scene is damaged");
        value = static_cast<std::remove_cvref_t<decltype(value)>>(number);
    }
}

/// A list or text; each element has at least one byte.
template <typename Archive, typename T>
requires requires(std::remove_const_t<T> list) { list.resize(0); }
void transfer(Archive& archive, T& list) {
    std::uint64_t count = list.size();
    archive.number(count);
    if constexpr (Archive::kReads) {
        if (count > archive.left()) throw InputError("the state of a scene is incomplete");
        list.resize(static_cast<std::size_t>(count));
    }
    for (auto& x : list) transfer(archive, x);
}

template <typename Archive, typename T>
requires requires(T& value) { value.has_value(); }
void transfer(Archive& archive, T& value) {
    bool present = value.has_value();
    transfer(archive, present);
    if constexpr (Archive::kReads) {
        if (present) value.emplace();
    }
    if (present) transfer(archive, *value);
}

template <typename Archive, Is<Vec3> T>
void transfer(Archive& archive, T& v) {
    transfer_all(archive, v.x, v.y, v.z);
}

template <typename Archive, Is<std::array<std::uint32_t, 3>> T>
void transfer(Archive& archive, T& triangle) {
    for (auto& corner : triangle) transfer(archive, corner);
}

template <typename Archive, Is<Bands> T>
void transfer(Archive& archive, T& bands) {
    for (auto& x : bands.value) transfer(archive, x);
}

template <typename Archive, Is<Pose> T>
void transfer(Archive& archive, T& pose) {
    transfer_all(archive, pose.position, pose.yaw_rad, pose.pitch_rad, pose.roll_rad);
}

template <typename Archive, Is<Trajectory::Keyframe> T>
void transfer(Archive& archive, T& point) {
    transfer_all(archive, point.time_s, point.pose);
}

template <typename Archive, Is<Trajectory> T>
void transfer(Archive& archive, T& path) {
    transfer_all(archive, path.points, path.loop);
}

template <typename Archive, Is<Object> T>
void transfer(Archive& archive, T& object) {
    transfer_all(archive, object.name, object.vertices, object.triangles, object.triangle_materials,
                 object.translation, object.path, object.movable);
}

template <typename Archive, Is<Material> T>
void transfer(Archive& archive, T& material) {
    transfer_all(archive, material.name, material.absorption, material.scattering,
                 material.sound_reduction_db);
}

template <typename Archive, Is<Medium> T>
void transfer(Archive& archive, T& medium) {
    transfer_all(archive, medium.temperature_c, medium.humidity_percent, medium.pressure_kpa,
                 medium.air_absorption);
}

/// The name, and of a file the factors in some directions, to recognise other content.
template <typename Archive>
void transfer_directivity(Archive& archive, auto& source) {
    std::string name;
    std::vector<Bands> factors;
    if constexpr (!Archive::kReads) {
        name = directivity_name(source);
        if (!source.directivity_file.empty()) factors = probe(source.directivity);
    }
    transfer_all(archive, name, factors);
    if constexpr (Archive::kReads) {
        set_directivity(source, name);
        if (!factors.empty() && factors != probe(source.directivity))
            throw InputError(name +
                             ": the directivity is not that of the scene; expected the "
                             "file's earlier content");
    }
}

template <typename Archive, Is<Source> T>
void transfer(Archive& archive, T& source) {
    transfer_all(archive, source.name, source.position, source.yaw_rad, source.pitch_rad,
                 source.roll_rad);
    transfer_directivity(archive, source);
    transfer_enum(archive, source.signal, static_cast<int>(Source::Signal::noise));
    std::string file = source.signal_file.string();
    transfer(archive, file);
    if constexpr (Archive::kReads) source.signal_file = utf8_path(file);
    transfer_all(archive, source.gain_db, source.loop, source.path, source.from_listener);
}

template <typename Archive>
void transfer_simulation(Archive& archive, auto& s, bool threads) {
    transfer_enum(archive, s.estimator, static_cast<int>(Estimator::patch));
    transfer_enum(archive, s.quality, static_cast<int>(Quality::fine));
    transfer_all(archive, s.rays, s.order, s.specular_order, s.specular, s.direct,
                 s.diffraction_order, s.transmission, s.response_time_s, s.patch_size_m,
                 s.listener_radius_m, s.frame_rate_hz, s.ir_length_s, s.seed, s.waves_hz);
    if (threads) transfer(archive, s.threads);
    transfer(archive, s.memory_mb);
}

template <typename Archive>
void transfer_scene(Archive& archive, auto& scene, bool threads) {
    transfer_all(archive, scene.objects, scene.materials, scene.medium, scene.sources,
                 scene.listener.pose, scene.listener.path, scene.speech.speech_db,
                 scene.speech.noise_db);
    transfer_simulation(archive, scene.simulation, threads);
}

}  // namespace

std::string directivity_name(const Source& source) {
    if (!source.directivity_file.empty()) return source.directivity_file.string();
    if (source.directivity.is_omnidirectional()) return "omni";
    const std::vector<Bands> factors = probe(source.directivity);
    for (const std::string& name : Directivity::names())
        if (factors == probe(*Directivity::find(name))) return name;
    throw InputError("the directivity of source \"" + source.name + "\" has no name");
}

void set_directivity(Source& source, const std::string& name) {
    const std::optional<Directivity> shipped = Directivity::find(name);
    source.directivity = shipped ? *shipped : load_directivity(utf8_path(name));
    source.directivity_file = shipped ? std::filesystem::path() : utf8_path(name);
}

std::string scene_state(const Scene& scene, bool threads) {
    Writer writer;
    transfer_scene(writer, scene, threads);
    return writer.take();
}

Scene scene_from_state(std::string_view state) {
    Reader reader(state);
    Scene scene;
    transfer_scene(reader, scene, true);
    if (reader.left() > 0) throw InputError("the state of a scene is too long");
    check_geometry(scene);
    for (const Material& material : scene.materials) check_material(material);
    scene.simulation.check();
    return scene;
}

void check_geometry(const Scene& scene) {
    for (const Object& object : scene.objects) {
        for (std::size_t v = 0; v < object.vertices.size(); ++v) {
            const Vec3& p = object.vertices[v];
            // The comparison also fails for NaN.
            for (const float x : {p.x, p.y, p.z})
                if (!(std::abs(x) <= kLargestCoordinate_m))
                    throw InputError("vertices: vertex " + std::to_string(v) +
                                     " is not usable; expected coordinates from -1e6 to 1e6 m");
        }
        for (std::size_t t = 0; t < object.triangles.size(); ++t)
            for (const std::uint32_t corner : object.triangles[t])
                if (corner >= object.vertices.size())
                    throw InputError("triangles: triangle " + std::to_string(t) +
                                     " has the vertex " + std::to_string(corner) +
                                     "; expected an index below " +
                                     std::to_string(object.vertices.size()));
        if (object.triangle_materials.size() != object.triangles.size())
            throw InputError("materials: " + std::to_string(object.triangle_materials.size()) +
                             " for " + std::to_string(object.triangles.size()) +
                             " triangles; expected one for each triangle");
        for (const std::uint32_t material : object.triangle_materials)
            if (material >= scene.materials.size())
                throw InputError("materials: there is no material " + std::to_string(material));
    }
}

}  // namespace aula
