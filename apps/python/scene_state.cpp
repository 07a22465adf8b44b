#include "apps/python/scene_state.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <numbers>
#include <optional>
#include <type_traits>
#include <vector>

#include "apps/session/auralizer/command_checks.h"
#include "aula/exception.h"

namespace aula {

namespace {

constexpr std::string_view kHeader = "aula scene 1\n";
constexpr float kLargestCoordinate_m = 1e6F;

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

// One function for each type both writes and reads it: `archive` is a Writer with constant values
// or a Reader.

template <typename Archive, typename T>
requires std::is_arithmetic_v<std::remove_cvref_t<T>>
void transfer(Archive& archive, T& x) { archive.number(x); }

template <typename Archive>
void transfer_flag(Archive& archive, auto& flag) {
    std::uint8_t byte = flag ? 1 : 0;
    archive.number(byte);
    if constexpr (Archive::kReads) flag = byte != 0;
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

/// A list; each element has at least one byte.
template <typename Archive>
void transfer_list(Archive& archive, auto& list, const auto& element) {
    std::uint64_t count = list.size();
    archive.number(count);
    if constexpr (Archive::kReads) {
        if (count > archive.left()) throw InputError("the state of a scene is incomplete");
        list.resize(static_cast<std::size_t>(count));
    }
    for (auto& x : list) element(x);
}

template <typename Archive>
void transfer_text(Archive& archive, auto& text) {
    transfer_list(archive, text, [&](auto& c) { archive.number(c); });
}

template <typename Archive>
void transfer_optional(Archive& archive, auto& value, const auto& content) {
    bool present = value.has_value();
    transfer_flag(archive, present);
    if constexpr (Archive::kReads) {
        if (present) value.emplace();
    }
    if (present) content(*value);
}

template <typename Archive>
void transfer_vector(Archive& archive, auto& v) {
    transfer(archive, v.x);
    transfer(archive, v.y);
    transfer(archive, v.z);
}

template <typename Archive>
void transfer_bands(Archive& archive, auto& bands) {
    for (auto& x : bands.value) transfer(archive, x);
}

template <typename Archive>
void transfer_pose(Archive& archive, auto& pose) {
    transfer_vector(archive, pose.position);
    transfer(archive, pose.yaw_rad);
    transfer(archive, pose.pitch_rad);
    transfer(archive, pose.roll_rad);
}

template <typename Archive>
void transfer_path(Archive& archive, auto& path) {
    transfer_optional(archive, path, [&](auto& trajectory) {
        transfer_list(archive, trajectory.points, [&](auto& point) {
            transfer(archive, point.time_s);
            transfer_pose(archive, point.pose);
        });
        transfer_flag(archive, trajectory.loop);
    });
}

template <typename Archive>
void transfer_object(Archive& archive, auto& object) {
    transfer_text(archive, object.name);
    transfer_list(archive, object.vertices, [&](auto& v) { transfer_vector(archive, v); });
    transfer_list(archive, object.triangles, [&](auto& triangle) {
        for (auto& corner : triangle) transfer(archive, corner);
    });
    transfer_list(archive, object.triangle_materials, [&](auto& m) { transfer(archive, m); });
    transfer_vector(archive, object.translation);
    transfer_path(archive, object.path);
    transfer_flag(archive, object.movable);
}

template <typename Archive>
void transfer_material(Archive& archive, auto& material) {
    transfer_text(archive, material.name);
    transfer_bands(archive, material.absorption);
    transfer_bands(archive, material.scattering);
    transfer_optional(archive, material.sound_reduction_db,
                      [&](auto& bands) { transfer_bands(archive, bands); });
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
    transfer_text(archive, name);
    transfer_list(archive, factors, [&](auto& bands) { transfer_bands(archive, bands); });
    if constexpr (Archive::kReads) {
        set_directivity(source, name);
        if (!factors.empty() && factors != probe(source.directivity))
            throw InputError(name +
                             ": the directivity is not that of the scene; expected the "
                             "file's earlier content");
    }
}

template <typename Archive>
void transfer_source(Archive& archive, auto& source) {
    transfer_text(archive, source.name);
    transfer_vector(archive, source.position);
    transfer(archive, source.yaw_rad);
    transfer(archive, source.pitch_rad);
    transfer(archive, source.roll_rad);
    transfer_directivity(archive, source);
    transfer_enum(archive, source.signal, static_cast<int>(Source::Signal::noise));
    std::string file = source.signal_file.string();
    transfer_text(archive, file);
    if constexpr (Archive::kReads) source.signal_file = file;
    transfer(archive, source.gain_db);
    transfer_flag(archive, source.loop);
    transfer_path(archive, source.path);
}

template <typename Archive>
void transfer_simulation(Archive& archive, auto& s, bool threads) {
    transfer_enum(archive, s.estimator, static_cast<int>(Estimator::patch));
    transfer(archive, s.rays);
    transfer(archive, s.order);
    transfer(archive, s.specular_order);
    transfer_flag(archive, s.specular);
    transfer_flag(archive, s.direct);
    transfer(archive, s.diffraction_order);
    transfer_flag(archive, s.transmission);
    transfer(archive, s.response_time_s);
    transfer(archive, s.patch_size_m);
    transfer(archive, s.listener_radius_m);
    transfer(archive, s.frame_rate_hz);
    transfer_optional(archive, s.ir_length_s, [&](auto& x) { transfer(archive, x); });
    transfer(archive, s.seed);
    if (threads) transfer_optional(archive, s.threads, [&](auto& x) { transfer(archive, x); });
    transfer(archive, s.memory_mb);
}

template <typename Archive>
void transfer_scene(Archive& archive, auto& scene, bool threads) {
    transfer_list(archive, scene.objects, [&](auto& x) { transfer_object(archive, x); });
    transfer_list(archive, scene.materials, [&](auto& x) { transfer_material(archive, x); });
    transfer(archive, scene.medium.temperature_c);
    transfer(archive, scene.medium.humidity_percent);
    transfer(archive, scene.medium.pressure_kpa);
    transfer_flag(archive, scene.medium.air_absorption);
    transfer_list(archive, scene.sources, [&](auto& x) { transfer_source(archive, x); });
    transfer_pose(archive, scene.listener.pose);
    transfer_path(archive, scene.listener.path);
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
    source.directivity = shipped ? *shipped : load_directivity(name);
    source.directivity_file = shipped ? std::filesystem::path() : std::filesystem::path(name);
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
