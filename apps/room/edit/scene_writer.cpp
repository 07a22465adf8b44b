#include "apps/room/edit/scene_writer.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <charconv>
#include <cstdint>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include "apps/output/json_text.h"
#include "apps/output/output_file.h"
#include "apps/output/printable.h"
#include "apps/room/frames/play_controls.h"
#include "aula/engine/material_library.h"
#include "engine/mesh/mesh_import.h"
#include "process/files.h"

namespace aula {

namespace {

JsonValue json_of(bool value) { return {value}; }
JsonValue json_of(int value) { return {static_cast<double>(value)}; }
JsonValue json_of(std::uint64_t value) { return {value}; }
JsonValue json_of(std::string value) { return {std::move(value)}; }

/// A number with the shortest text of the float, not of its double.
JsonValue json_of(float value) {
    const std::string text = json_number(value);
    double number = 0;
    std::from_chars(text.data(), text.data() + text.size(), number);
    return {number};
}

JsonValue json_of(const Vec3& p) {
    return {JsonValue::Array{json_of(p.x), json_of(p.y), json_of(p.z)}};
}

/// A single number if all bands are equal.
JsonValue json_of(const Bands& bands) {
    const auto& values = bands.value;
    if (std::adjacent_find(values.begin(), values.end(), std::not_equal_to<>()) == values.end())
        return json_of(values[0]);
    JsonValue::Array numbers;
    for (const float value : values) numbers.push_back(json_of(value));
    return {std::move(numbers)};
}

JsonValue* find(JsonValue& object, const std::string& key) {
    for (JsonMember& member : std::get<JsonValue::Object>(object.value))
        if (member.key == key) return &member.value;
    return nullptr;
}

void set(JsonValue& object, const std::string& key, JsonValue value) {
    if (JsonValue* const member = find(object, key))
        *member = std::move(value);
    else
        std::get<JsonValue::Object>(object.value).push_back({key, std::move(value)});
}

void remove(JsonValue& object, const std::string& key) {
    std::erase_if(std::get<JsonValue::Object>(object.value),
                  [&](const JsonMember& member) { return member.key == key; });
}

/// The member that is an object; created if absent.
JsonValue& member_object(JsonValue& parent, const std::string& key) {
    if (find(parent, key) == nullptr) set(parent, key, {JsonValue::Object{}});
    return *find(parent, key);
}

void set_angle(JsonValue& object, const std::string& key, float before_rad, float now_rad) {
    if (now_rad == before_rad) return;
    set(object, key, json_of(now_rad * 180 / std::numbers::pi_v<float>));
}

/// Converts file names relative to the folder `from` to names relative to the folder `to`.
class FileNames {
 public:
    FileNames(const std::filesystem::path& from, const std::filesystem::path& to)
        : prefix_(std::filesystem::weakly_canonical(std::filesystem::absolute(from))
                      .lexically_proximate(
                          std::filesystem::weakly_canonical(std::filesystem::absolute(to)))) {}

    void move(JsonValue* name) const {
        if (name == nullptr || prefix_ == ".") return;
        auto& text = std::get<std::string>(name->value);
        if (utf8_path(text).is_relative()) text = (prefix_ / utf8_path(text)).string();
    }

 private:
    std::filesystem::path prefix_;
};

/// The materials of triangles that differ from the file: each with the ranges [first, last] of its
/// triangles.
std::map<std::string, JsonValue::Array> changed_ranges(const Scene& before, const Object& old,
                                                       const Scene& now, const Object& object) {
    std::map<std::string, JsonValue::Array> ranges;
    const auto material = [&](std::size_t t) -> const Material& {
        return now.materials[object.triangle_materials[t]];
    };
    const auto changed = [&](std::size_t t) {
        return before.materials[old.triangle_materials[t]] != material(t);
    };
    const std::size_t count = object.triangles.size();
    for (std::size_t first = 0; first < count; ++first) {
        if (!changed(first)) continue;
        std::size_t last = first;
        while (last + 1 < count && changed(last + 1) &&
               object.triangle_materials[last + 1] == object.triangle_materials[first])
            ++last;
        ranges[material(first).name].push_back(
            {JsonValue::Array{json_of(std::uint64_t{first}), json_of(std::uint64_t{last})}});
        first = last;
    }
    return ranges;
}

/// Writes the present materials of an object to its piece of geometry.
void write_surfaces(JsonValue& item, const Scene& before, const Object& old, const Scene& now,
                    const Object& object) {
    auto ranges = changed_ranges(before, old, now, object);
    if (ranges.empty()) return;
    const auto& materials = object.triangle_materials;
    const bool alike = std::adjacent_find(materials.begin(), materials.end(),
                                          std::not_equal_to<>()) == materials.end();
    if (JsonValue* const single = find(item, "material"); single != nullptr && alike) {
        *single = json_of(now.materials[materials[0]].name);
        remove(item, "surfaces");
        return;
    }
    if (find(item, "surfaces") == nullptr) set(item, "surfaces", {JsonValue::Array{}});
    auto& surfaces = std::get<JsonValue::Array>(find(item, "surfaces")->value);
    for (auto& [name, triangles] : ranges)
        surfaces.push_back({JsonValue::Object{{"material", json_of(name)},
                                              {"triangles", {std::move(triangles)}}}});
}

/// Adds the materials that neither the file nor Aula's library has.
void write_materials(JsonValue& root, const Scene& before, const Scene& now) {
    std::vector<Material> known = before.materials;
    // The scene's own take precedence over those of the library.
    for (LibraryMaterial& entry : material_library())
        if (std::none_of(known.begin(), known.end(),
                         [&](const Material& m) { return m.name == entry.material.name; }))
            known.push_back(std::move(entry.material));
    std::set<std::uint32_t> used;
    for (const Object& object : now.objects)
        used.insert(object.triangle_materials.begin(), object.triangle_materials.end());
    for (const std::uint32_t index : used) {
        const Material& material = now.materials[index];
        if (std::find(known.begin(), known.end(), material) != known.end()) continue;
        JsonValue coefficients{JsonValue::Object{{"absorption", json_of(material.absorption)},
                                                 {"scattering", json_of(material.scattering)}}};
        if (material.sound_reduction_db)
            set(coefficients, "sound_reduction_db", json_of(*material.sound_reduction_db));
        set(member_object(root, "materials"), material.name, std::move(coefficients));
    }
}

void write_source(JsonValue& item, const Source& before, const Source& now) {
    // The place on a listener is that of the file; a source that was moved has left it.
    if (!now.from_listener) {
        const bool stops = (before.path && !now.path) || before.from_listener;
        for (const char* const key : {"path", "relative_to"})
            if (stops) remove(item, key);
        if (stops || before.position != now.position) set(item, "position", json_of(now.position));
        const Source initial = before.from_listener ? Source{} : before;
        set_angle(item, "yaw_deg", initial.yaw_rad, now.yaw_rad);
        set_angle(item, "pitch_deg", initial.pitch_rad, now.pitch_rad);
        set_angle(item, "roll_deg", initial.roll_rad, now.roll_rad);
    }
    if (before.gain_db != now.gain_db) set(item, "gain_db", json_of(now.gain_db));
    if (before.loop != now.loop) set(item, "loop", json_of(now.loop));
}

void write_listener(JsonValue& item, const Listener& before, const Listener& now) {
    const bool stops = before.path && !now.path;
    if (stops) remove(item, "path");
    if (stops || before.pose.position != now.pose.position)
        set(item, "position", json_of(now.pose.position));
    set_angle(item, "yaw_deg", before.pose.yaw_rad, now.pose.yaw_rad);
    set_angle(item, "pitch_deg", before.pose.pitch_rad, now.pose.pitch_rad);
    set_angle(item, "roll_deg", before.pose.roll_rad, now.pose.roll_rad);
}

void write_simulation(JsonValue& root, const Simulation& before, const Simulation& now) {
    const auto write = [&](const char* key, auto Simulation::*member) {
        if (before.*member == now.*member) return;
        set(member_object(root, "simulation"), key, json_of(now.*member));
    };
    const auto write_optional = [&](const char* key, auto Simulation::*member) {
        if (before.*member == now.*member) return;
        JsonValue& simulation = member_object(root, "simulation");
        if (now.*member)
            set(simulation, key, json_of(*(now.*member)));
        else
            remove(simulation, key);
    };
    if (before.estimator != now.estimator)
        set(member_object(root, "simulation"), "estimator",
            json_of(std::string(estimator_name(now.estimator))));
    if (before.quality != now.quality)
        set(member_object(root, "simulation"), "quality",
            json_of(std::string(quality_name(now.quality))));
    write_optional("rays", &Simulation::rays);
    write("order", &Simulation::order);
    write("specular_order", &Simulation::specular_order);
    write("specular", &Simulation::specular);
    write("direct", &Simulation::direct);
    write("transmission", &Simulation::transmission);
    write("diffraction_order", &Simulation::diffraction_order);
    write("response_time_s", &Simulation::response_time_s);
    write("patch_size_m", &Simulation::patch_size_m);
    write("listener_radius_m", &Simulation::listener_radius_m);
    write("frame_rate_hz", &Simulation::frame_rate_hz);
    write_optional("ir_length_s", &Simulation::ir_length_s);
    write("seed", &Simulation::seed);
    write_optional("threads", &Simulation::threads);
    write("memory_mb", &Simulation::memory_mb);
    if (before.waves_hz != now.waves_hz)
        set(member_object(root, "simulation"), "waves",
            now.waves_hz == 0                              ? json_of(false)
            : now.waves_hz == Simulation::kHighestWaves_hz ? json_of(std::string("auto"))
                                                           : json_of(now.waves_hz));
}

}  // namespace

std::string edited_scene_text(const LoadedScene& read, const Scene& edited,
                              const std::filesystem::path& from, const std::filesystem::path& to) {
    const Scene& before = read.scene;
    assert(edited.objects.size() == before.objects.size());
    assert(edited.sources.size() == before.sources.size());
    JsonValue root = *read.json;
    const FileNames files(from, to);
    for (std::size_t i = 0; i < before.objects.size(); ++i) {
        JsonValue& item = std::get<JsonValue::Array>(find(root, "geometry")->value)[i];
        files.move(find(item, "file"));
        write_surfaces(item, before, before.objects[i], edited, edited.objects[i]);
    }
    write_materials(root, before, edited);
    for (std::size_t s = 0; s < before.sources.size(); ++s) {
        JsonValue& item = std::get<JsonValue::Array>(find(root, "sources")->value)[s];
        if (before.sources[s].signal == Source::Signal::file) files.move(find(item, "signal"));
        if (!before.sources[s].directivity_file.empty()) files.move(find(item, "directivity"));
        write_source(item, before.sources[s], edited.sources[s]);
    }
    write_listener(*find(root, "listener"), before.listener, edited.listener);
    write_simulation(root, before.simulation, edited.simulation);
    return json_text(root) + '\n';
}

std::string model_comment(const std::filesystem::path& model,
                          const std::vector<std::string>& guesses) {
    std::string text = "// The scene of " + printable_line(model.filename().string()) +
                       ", for editing (docs/scene_format.md).\n";
    if (!guesses.empty()) text += "// The model does not say, and Aula has guessed:\n";
    for (const std::string& guess : guesses) text += "// * " + printable_line(guess) + "\n";
    return text;
}

void write_edited_scene(const LoadedScene& read, const Scene& edited,
                        const std::filesystem::path& scene_file,
                        const std::filesystem::path& file) {
    OutputFile out(file);
    if (is_mesh_file(scene_file)) out.write(model_comment(scene_file, read.guesses));
    out.write(edited_scene_text(read, edited, std::filesystem::absolute(scene_file).parent_path(),
                                std::filesystem::absolute(file).parent_path()));
    out.commit();
}

}  // namespace aula
