#include "engine/model/model_scene.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <numbers>
#include <set>
#include <string_view>
#include <utility>

#include "aula/engine/material_library.h"
#include "aula/exception.h"
#include "engine/input/material_guess.h"
#include "engine/input/names.h"
#include "engine/mesh/mesh_import.h"
#include "engine/model/standing_places.h"
#include "engine/model/unit_guess.h"
#include "engine/rays/ray_scene.h"
#include "engine/scene/scene_values.h"
#include "process/files.h"
#include "process/regular_file.h"

namespace aula {

namespace {

namespace fs = std::filesystem;

/// A number with at most three decimals.
JsonValue rounded(double x) { return {std::round(x * 1000) / 1000}; }

JsonValue text(std::string words) { return {std::move(words)}; }

JsonValue point(const Vec3& p) {
    return {JsonValue::Array{rounded(double{p.x}), rounded(double{p.y}), rounded(double{p.z})}};
}

std::string point_text(const Vec3& p) {
    std::array<char, 64> line{};
    std::snprintf(line.data(), line.size(), "(%.2f, %.2f, %.2f)", double{p.x}, double{p.y},
                  double{p.z});
    return line.data();
}

void set(JsonValue::Object& object, std::string key, JsonValue value) {
    object.push_back({std::move(key), std::move(value)});
}

/// Names without the number that programs append to copies: "Wall.001".
std::string without_number(const std::string& name) {
    const std::size_t dot = name.rfind('.');
    const bool is_number = dot != std::string::npos && dot > 0 && dot + 1 < name.size() &&
                           std::all_of(name.begin() + static_cast<std::ptrdiff_t>(dot) + 1,
                                       name.end(), [](unsigned char c) { return std::isdigit(c); });
    return is_number ? name.substr(0, dot) : name;
}

/// "White Wood" as the library would spell it: "white_wood".
std::string library_spelling(std::string name) {
    for (char& c : name)
        c = c == ' ' || c == '-' ? '_'
                                 : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return name;
}

/// Whether the first bytes are those of a file that read_sound() may read: the formats of
/// audio/file/sound_decoder.cpp.
bool is_sound(std::string_view mark) {
    constexpr std::array<std::string_view, 11> kMarks{
        "RIFF", "RIFX", "RF64", "riff", "FORM", ".snd", "dns.", "caff", "fLaC", "OggS", "NIST"};
    if (mark.starts_with("ID3") || std::find(kMarks.begin(), kMarks.end(), mark) != kMarks.end())
        return true;
    // A frame of MPEG audio; layer 0 is AAC.
    return mark.size() > 1 && mark[0] == '\xff' && (mark[1] & 0xe0) == 0xe0 &&
           (mark[1] & 0x06) != 0;
}

Bounds bounds_of(const std::vector<Vec3>& vertices) {
    Bounds bounds;
    bounds.add(vertices);
    return bounds;
}

/// The area of triangles as seen along each axis.
Vec3 projected_area(const ImportedMesh& mesh, const std::vector<char>& counted) {
    glm::dvec3 area(0);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        if (counted[mesh.triangle_materials[t]] == 0) continue;
        const auto& [a, b, c] = mesh.triangles[t];
        area += glm::abs(glm::cross(glm::dvec3(mesh.vertices[b]) - glm::dvec3(mesh.vertices[a]),
                                    glm::dvec3(mesh.vertices[c]) - glm::dvec3(mesh.vertices[a])));
    }
    return Vec3(area / std::max(area.x + area.y + area.z, 1e-300));
}

/// Makes the scene of one model.
class SceneMaker {
 public:
    SceneMaker(const fs::path& file, const fs::path& folder, const ModelOptions& options)
        : file_(file),
          folder_(folder),
          options_(options),
          mesh_(import_mesh(file)),
          library_(material_library()),
          is_gltf_(is_gltf_file(file)) {}

    ModelScene make() {
        if (mesh_.scene_count > 1)
            guess("scene: " + quoted(std::as_const(mesh_.scene)) + ", one of " +
                  std::to_string(mesh_.scene_count) + " in the file");
        if (const std::size_t count = mesh_.global_emitter_count; count > 0)
            guess("sounds: without " + std::to_string(count) +
                  (count > 1 ? " global emitters" : " global emitter") + ", which have no place");
        JsonValue::Object geometry;
        set(geometry, "file", text(name_of(file_)));
        find_up(geometry);
        find_scale(geometry);
        map_materials(geometry);
        find_places();

        JsonValue::Object scene;
        set(scene, "aula", {std::uint64_t{1}});
        set(scene, "geometry", {JsonValue::Array{{std::move(geometry)}}});
        if (!materials_.empty()) set(scene, "materials", {std::move(materials_)});
        set(scene, "sources", {std::move(sources_)});
        set(scene, "listener", {std::move(listener_)});
        return {{std::move(scene)}, std::move(guesses_)};
    }

 private:
    /// A file's name in the scene.
    std::string name_of(const fs::path& file) const {
        return fs::proximate(fs::absolute(file), fs::absolute(folder_ / ".")).string();
    }

    void guess(std::string line) { guesses_.push_back(std::move(line)); }

    // A room is lower than wide, and its floor and ceiling are horizontal.
    void find_up(JsonValue::Object& geometry) {
        bool y_up = is_gltf_;
        if (options_.y_is_up) {
            y_up = *options_.y_is_up;
        } else if (!is_gltf_) {
            std::vector<char> horizontal;
            for (const std::string& name : mesh_.material_names)
                horizontal.push_back(names_horizontal_part(name) ? 1 : 0);
            const Vec3 area = projected_area(mesh_, horizontal);
            const Bounds bounds = bounds_of(mesh_.vertices);
            const Vec3 size = bounds.max - bounds.min;
            constexpr float kClearly = 2;  // stairs and tables with the same names have other faces
            constexpr float kLower = 0.8F;  // nearly equal extents say nothing
            if (area.y > kClearly * area.z) {
                y_up = true;
                guess("up: y, the faces named as floors and ceilings lie across it");
            } else if (!(area.z > kClearly * area.y) && size.y < kLower * size.z) {
                y_up = true;
                guess("up: y, the model of " + size_text(size) + " is lower than deep that way");
            } else if (!(area.z > kClearly * area.y) && !(size.z < kLower * size.y)) {
                guess("up: z, neither names nor the extents of " + size_text(size) +
                      " say (--up y sets the other)");
            }
        }
        if (y_up != is_gltf_) set(geometry, "up", text(y_up ? "y" : "z"));
        if (!y_up) return;
        for (Vec3& v : mesh_.vertices) v = {v.x, -v.z, v.y};
        for (ImportedPlace& place : mesh_.places) {
            // Without a negative zero in texts.
            place.position = {place.position.x, 0 - place.position.z, place.position.y};
            place.front = {place.front.x, 0 - place.front.z, place.front.y};
        }
    }

    void find_scale(JsonValue::Object& geometry) {
        const Bounds bounds = bounds_of(mesh_.vertices);
        const glm::dvec3 size = glm::dvec3(bounds.max) - glm::dvec3(bounds.min);
        double scale = options_.scale.value_or(1);
        if (const auto unit = options_.scale ? std::nullopt : guess_unit(size)) {
            scale = unit->metres;
            guess(std::string("unit: ") + unit->name + ", a model of " + size_text(Vec3(size)) +
                  " is " + size_text(Vec3(size * scale)) + " m (--scale S sets another)");
        }
        if (scale != 1) set(geometry, "scale", {scale});
        for (Vec3& v : mesh_.vertices) v = Vec3(glm::dvec3(v) * scale);
        for (ImportedPlace& place : mesh_.places)
            place.position = Vec3(glm::dvec3(place.position) * scale);
    }

    bool is_in_library(const std::string& name) const {
        return std::any_of(library_.begin(), library_.end(), [&](const LibraryMaterial& entry) {
            return entry.material.name == name;
        });
    }

    const JsonValue::Object* extras_of(const std::string& name) const {
        for (const auto& [of, extras] : mesh_.material_extras)
            if (of == name) return &std::get<JsonValue::Object>(extras.value);
        return nullptr;
    }

    /// The material that the "extras" of a material of glTF describe, if they do.
    std::optional<std::string> described(const std::string& name) {
        const JsonValue::Object* const extras = extras_of(name);
        if (extras == nullptr) return std::nullopt;
        JsonValue::Object properties;
        for (const JsonMember& member : *extras) {
            const auto* const named = std::get_if<std::string>(&member.value.value);
            if (member.key == "aula_material" && named != nullptr) return *named;
            for (const char* const key : {"absorption", "scattering", "sound_reduction_db"})
                if (member.key == key) properties.push_back(member);
        }
        const bool has_absorption =
            std::any_of(properties.begin(), properties.end(),
                        [](const JsonMember& member) { return member.key == "absorption"; });
        if (!has_absorption) return std::nullopt;
        set(materials_, name, {std::move(properties)});
        return name;
    }

    void map_materials(JsonValue::Object& geometry) {
        std::vector<char> used(mesh_.material_names.size(), 0);
        for (const std::uint32_t material : mesh_.triangle_materials) used[material] = 1;
        JsonValue::Object mapped;
        std::vector<std::string> unknown;  // last, where they are noticed
        for (std::size_t m = 0; m < used.size(); ++m) {
            if (used[m] == 0) continue;
            const std::string& name = mesh_.material_names[m];
            if (const auto known = described(name)) {
                if (*known != name) set(mapped, name, text(*known));
                continue;
            }
            if (is_in_library(name)) continue;
            std::string plain = library_spelling(without_number(name));
            if (!is_in_library(plain)) {
                const MaterialGuess guessed = guess_material(name);
                plain = guessed.material;
                const std::string line = "material " + quoted(name) + ": " + plain;
                if (guessed.word.empty())
                    unknown.push_back(line + ", no known word is in its name");
                else
                    guess(line + ", \"" + guessed.word + "\" is in its name");
            }
            set(mapped, name, text(plain));
        }
        for (const std::string& line : unknown) guess(line);
        if (!mapped.empty()) set(geometry, "materials", {std::move(mapped)});
    }

    Scene geometry_scene() const {
        Object object;
        object.vertices = mesh_.vertices;
        object.triangles = mesh_.triangles;
        object.triangle_materials.assign(mesh_.triangles.size(), 0);
        Scene scene;
        scene.materials.emplace_back();
        scene.objects.push_back(std::move(object));
        return scene;
    }

    static void face(JsonValue::Object& object, const Vec3& front) {
        if (!(glm::length(front) > 0)) return;
        constexpr double kDegrees = 180 / std::numbers::pi;
        const double level = std::hypot(double{front.x}, double{front.y});
        const double yaw_deg =
            level > 0 ? std::atan2(double{front.y}, double{front.x}) * kDegrees : 0;
        const double pitch_deg = std::atan2(double{front.z}, level) * kDegrees;
        // In whole degrees, which is the accuracy of localisation in front.
        if (std::round(yaw_deg) != 0) set(object, "yaw_deg", {std::round(yaw_deg)});
        if (std::round(pitch_deg) != 0) set(object, "pitch_deg", {std::round(pitch_deg)});
    }

    /// The first bytes of a sound inside the model. Throws InputError.
    const std::string& beginning_of(const SoundInModel& inside) const {
        const SoundBeginning& sound = mesh_.sounds_inside.at(inside.number);
        if (!sound.error.empty()) throw InputError(inside.name().string() + ": " + sound.error);
        return sound.bytes;
    }

    /// The sound of a place, if its file is there.
    std::optional<std::string> sound_of(const ImportedPlace& place) {
        if (!place.sound_inside && place.sound.empty()) return std::nullopt;
        const SoundInModel inside{file_, place.sound_inside.value_or(0)};
        const fs::path name =
            place.sound_inside ? inside.name() : file_.parent_path() / utf8_path(place.sound);
        std::error_code error;
        if (!place.sound_inside && !fs::is_regular_file(name, error)) {
            guess("source " + quoted(place.name) + ": claps, its sound " + quoted(name.string()) +
                  " is missing");
            return std::nullopt;
        }
        try {
            if (is_sound(place.sound_inside
                             ? beginning_of(inside)
                             : RegularFile(name, "a sound").read(0, SoundBeginning::kBytes)))
                return name_of(name);
            guess("source " + quoted(place.name) + ": claps, its sound " + quoted(name.string()) +
                  (place.sound_type.empty() ? "" : " of the type " + quoted(place.sound_type)) +
                  " is of a format that is not read; expected WAV, RF64, W64, AIFF, AU, CAF, "
                  "FLAC, Ogg, MP3 or NIST SPHERE");
        } catch (const InputError& reason) {
            guess("source " + quoted(place.name) + ": claps, " + reason.what());
        }
        return std::nullopt;
    }

    void guess_by_name(const ImportedPlace& place, const std::string& kind) {
        guess(kind + " " + quoted(place.name) + " at " + point_text(place.position) + ": \"" +
              place.guessed_by + "\" is in its name");
    }

    void add_source(const ImportedPlace& place) {
        if (!place.guessed_by.empty()) guess_by_name(place, "source");
        const std::optional<std::string> sound = sound_of(place);
        JsonValue::Object source;
        const std::string given = place.name.empty() ? "source" : place.name;
        std::string name = given;
        for (int copy = 2; !source_names_.insert(name).second; ++copy)
            name = given + " " + std::to_string(copy);
        set(source, "name", text(name));
        set(source, "position", point(place.position));
        face(source, place.front);
        // Without a sound one hears a clap each second.
        set(source, "signal", text(sound.value_or("impulse")));
        if (place.loop || !sound) set(source, "loop", {true});
        constexpr double kLowest_db = -200;  // of scene files
        const double gain_db =
            place.gain > 0 ? std::max(20 * std::log10(place.gain), kLowest_db) : kLowest_db;
        if (std::abs(gain_db) > 1e-3) set(source, "gain_db", rounded(gain_db));
        sources_.push_back({std::move(source)});
    }

    void find_places() {
        std::vector<ImportedPlace> sources;
        std::optional<ImportedPlace> listener;
        for (const ImportedPlace& place : mesh_.places) {
            if (place.kind == ImportedPlace::Kind::source)
                sources.push_back(place);
            else if (!listener)
                listener = place;
        }
        if (sources.empty() || !listener) {
            const Bounds bounds = bounds_of(mesh_.vertices);
            const Scene scene = geometry_scene();
            const RayScene rays(scene);
            // Reading the scene refuses larger coordinates.
            const Bounds readable{Vec3(-kLargestCoordinate_m), Vec3(kLargestCoordinate_m)};
            const bool is_readable = readable.contains(bounds.min) && readable.contains(bounds.max);
            const std::vector<Vec3> places =
                is_readable ? standing_places(rays, bounds) : std::vector<Vec3>();
            const Vec3 middle = (bounds.min + bounds.max) / 2.0F;
            const std::string reason = places.empty()
                                           ? "the middle of the model, which has no place "
                                             "to stand"
                                           : "a place where people can stand";
            if (sources.empty()) {
                ImportedPlace& source = sources.emplace_back();
                source.name = "clap";
                source.position = source_place(rays, places).value_or(middle);
                guess("source \"clap\" at " + point_text(source.position) + ": " + reason);
                if (const std::size_t count = mesh_.shapes_of_sources.size(); count > 0)
                    guess("shape " + quoted(std::as_const(mesh_.shapes_of_sources[0])) +
                          (count > 1 ? " and " + std::to_string(count - 1) + " more" : "") +
                          ": no source; an object without faces, of such a name, before it is one");
            }
            if (!listener) {
                listener.emplace();
                listener->position = listener_place(rays, places, sources[0].position)
                                         .value_or(sources[0].position + Vec3(1, 0, 0));
                listener->front = sources[0].position - listener->position;
                listener->front.z = 0;
                guess("listener at " + point_text(listener->position) + ": " + reason);
            }
            if (sources[0].front == Vec3(0)) {
                sources[0].front = listener->position - sources[0].position;
                sources[0].front.z = 0;
            }
        }
        for (const ImportedPlace& source : sources) add_source(source);
        if (!listener->guessed_by.empty()) guess_by_name(*listener, "listener");
        set(listener_, "position", point(listener->position));
        face(listener_, listener->front);
    }

    fs::path file_, folder_;
    ModelOptions options_;
    ImportedMesh mesh_;
    std::vector<LibraryMaterial> library_;
    bool is_gltf_;
    JsonValue::Object materials_;
    JsonValue::Array sources_;
    std::set<std::string> source_names_;
    JsonValue::Object listener_;
    std::vector<std::string> guesses_;
};

}  // namespace

ModelScene scene_of_model(const fs::path& file, const fs::path& folder,
                          const ModelOptions& options) {
    std::error_code error;
    if (!fs::exists(file, error))
        throw InputError(file.string(), "", "no such file; expected a model");
    try {
        return SceneMaker(file, folder, options).make();
    } catch (const InputError& reason) {
        throw InputError(file.string() + ": " + reason.what());
    }
}

}  // namespace aula
