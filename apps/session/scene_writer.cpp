#include "apps/session/scene_writer.h"

#include <algorithm>
#include <cstdint>
#include <numbers>
#include <set>
#include <vector>

#include "apps/session/json_text.h"
#include "apps/session/output_file.h"

namespace aula {

namespace {

std::string list(const std::vector<std::string>& items) {
    std::string text = "[";
    for (std::size_t i = 0; i < items.size(); ++i) text += (i > 0 ? "," : "") + items[i];
    return text + "]";
}

/// Members of an object, one line each or all in one.
class Members {
 public:
    void add(const std::string& key, const std::string& value) {
        text_ += (text_.empty() ? "" : ", ") + json_string(key) + ": " + value;
    }
    void add(const std::string& key, bool value) {
        add(key, std::string(value ? "true" : "false"));
    }
    std::string text() const { return "{" + text_ + "}"; }

 private:
    std::string text_;
};

std::string point(const Vec3& p) {
    return list({json_number(p.x), json_number(p.y), json_number(p.z)});
}

std::string degrees(float angle_rad) {
    return json_number(angle_rad * 180 / std::numbers::pi_v<float>);
}

std::string shares(const Bands& bands) {
    std::vector<std::string> numbers;
    for (const float share : bands.value) numbers.push_back(json_number(share));
    return list(numbers);
}

void add_orientation(Members& members, const Pose& pose) {
    if (pose.yaw_rad != 0) members.add("yaw_deg", degrees(pose.yaw_rad));
    if (pose.pitch_rad != 0) members.add("pitch_deg", degrees(pose.pitch_rad));
    if (pose.roll_rad != 0) members.add("roll_deg", degrees(pose.roll_rad));
}

std::string path_text(const Path& path) {
    std::vector<std::string> points;
    for (const Path::Point& p : path.points) {
        Members members;
        members.add("t", json_number(p.time_s));
        members.add("position", point(p.pose.position));
        add_orientation(members, p.pose);
        points.push_back(members.text());
    }
    Members members;
    if (path.loop) members.add("loop", true);
    members.add("points", list(points));
    return members.text();
}

/// The part of an object that is of one material.
std::string object_part(const Object& object, std::uint32_t material,
                        const std::string& material_name, const std::string& name) {
    std::vector<std::uint32_t> number(object.vertices.size(), 0);  // 0: not used, else one more
    std::vector<std::string> vertices;
    std::vector<std::string> faces;
    for (std::size_t t = 0; t < object.triangles.size(); ++t) {
        if (object.triangle_materials[t] != material) continue;
        std::vector<std::string> corners;
        for (const std::uint32_t v : object.triangles[t]) {
            if (number[v] == 0) {
                vertices.push_back(point(object.vertices[v]));
                number[v] = static_cast<std::uint32_t>(vertices.size());
            }
            corners.push_back(std::to_string(number[v] - 1));
        }
        faces.push_back(list(corners));
    }
    Members members;
    if (!name.empty()) members.add("name", json_string(name));
    members.add("material", json_string(material_name));
    if (object.translation != Vec3(0)) members.add("translate", point(object.translation));
    members.add("vertices", list(vertices));
    members.add("faces", list(faces));
    if (object.path) members.add("path", path_text(*object.path));
    return members.text();
}

std::vector<std::string> object_texts(const Scene& scene) {
    std::vector<std::string> texts;
    std::set<std::string> names;
    for (const Object& object : scene.objects) names.insert(object.name);
    for (const Object& object : scene.objects) {
        const std::set<std::uint32_t> materials(object.triangle_materials.begin(),
                                                object.triangle_materials.end());
        bool first = true;
        for (const std::uint32_t material : materials) {
            std::string name = object.name;
            for (int part = 2; !first && !name.empty() && names.contains(name); ++part)
                name = object.name + " " + std::to_string(part);
            names.insert(name);
            first = false;
            texts.push_back(object_part(object, material, scene.materials[material].name, name));
        }
    }
    return texts;
}

std::string source_text(const Source& source, const std::filesystem::path& folder) {
    Members members;
    members.add("name", json_string(source.name));
    members.add("position", point(source.position));
    switch (source.signal) {
        case Source::Signal::impulse:
            members.add("signal", json_string("impulse"));
            break;
        case Source::Signal::noise:
            members.add("signal", json_string("noise"));
            break;
        case Source::Signal::file: {
            const auto absolute = std::filesystem::absolute(source.signal_file);
            const auto relative = absolute.lexically_normal().lexically_relative(
                std::filesystem::absolute(folder).lexically_normal());
            members.add("signal", json_string((relative.empty() ? absolute : relative).string()));
            break;
        }
    }
    members.add("gain_db", json_number(source.gain_db));
    members.add("loop", source.loop);
    if (source.path) members.add("path", path_text(*source.path));
    return members.text();
}

std::string simulation_text(const Simulation& s) {
    Members members;
    members.add("estimator", json_string(estimator_name(s.estimator)));
    members.add("rays", std::to_string(s.rays));
    members.add("order", std::to_string(s.order));
    members.add("specular_order", std::to_string(s.specular_order));
    members.add("specular", s.specular);
    members.add("direct", s.direct);
    members.add("response_time_s", json_number(s.response_time_s));
    members.add("patch_size_m", json_number(s.patch_size_m));
    members.add("listener_radius_m", json_number(s.listener_radius_m));
    members.add("frame_rate_hz", json_number(s.frame_rate_hz));
    if (s.ir_length_s) members.add("ir_length_s", json_number(*s.ir_length_s));
    members.add("seed", std::to_string(s.seed));
    if (s.threads) members.add("threads", std::to_string(*s.threads));
    members.add("memory_mb", std::to_string(s.memory_mb));
    return members.text();
}

std::string lines(const std::vector<std::string>& items, char open, char close) {
    std::string text(1, open);
    for (std::size_t i = 0; i < items.size(); ++i)
        text += std::string(i > 0 ? "," : "") + "\n    " + items[i];
    return text + "\n  " + close;
}

}  // namespace

std::string scene_text(const Scene& scene, const std::filesystem::path& folder) {
    std::vector<std::string> materials;
    for (const Material& material : scene.materials) {
        Members members;
        members.add("absorption", shares(material.absorption));
        members.add("scattering", shares(material.scattering));
        materials.push_back(json_string(material.name) + ": " + members.text());
    }
    std::vector<std::string> sources;
    for (const Source& source : scene.sources) sources.push_back(source_text(source, folder));
    Members medium;
    medium.add("temperature_c", json_number(scene.medium.temperature_c));
    medium.add("humidity_percent", json_number(scene.medium.humidity_percent));
    medium.add("pressure_kpa", json_number(scene.medium.pressure_kpa));
    medium.add("air_absorption", scene.medium.air_absorption);
    Members listener;
    listener.add("position", point(scene.listener.pose.position));
    add_orientation(listener, scene.listener.pose);
    if (scene.listener.path) listener.add("path", path_text(*scene.listener.path));

    std::string text = "{\n  \"aula\": 1";
    const auto add = [&](const std::string& key, const std::string& value) {
        text += ",\n  " + json_string(key) + ": " + value;
    };
    if (!materials.empty()) add("materials", lines(materials, '{', '}'));
    if (!scene.objects.empty()) add("geometry", lines(object_texts(scene), '[', ']'));
    add("medium", medium.text());
    add("sources", lines(sources, '[', ']'));
    add("listener", listener.text());
    add("simulation", simulation_text(scene.simulation));
    return text + "\n}\n";
}

void write_scene(const Scene& scene, const std::filesystem::path& file) {
    OutputFile out(file);
    out.write(scene_text(scene, std::filesystem::absolute(file).parent_path()));
    out.commit();
}

}  // namespace aula
