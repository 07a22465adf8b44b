#include "engine/scene_values.h"

#include <glm/trigonometric.hpp>

namespace aula {
namespace {

constexpr NumberRange kShare{0, 1, true, "a number from 0 to 1"};
constexpr NumberRange kAngle_deg{-1e6, 1e6, true, "degrees from -1e6 to 1e6"};
constexpr NumberRange kTime_s{0, 1e9, true, "seconds from 0 to 1e9"};
constexpr NumberRange kCoordinate_m{-kLargestCoordinate_m, kLargestCoordinate_m, true,
                                    "metres from -1e6 to 1e6"};

float read_angle_rad(const JsonReader& json, const char* key) {
    const auto angle = json.find(key);
    return angle ? glm::radians(angle->real(kAngle_deg)) : 0.0F;
}

}  // namespace

Vec3 read_point(const JsonReader& json) {
    constexpr const char* kExpected = "a list of 3 numbers, x, y, z in metres";
    const auto items = json.items(kExpected);
    if (items.size() != 3) {
        json.fail("a list of " + std::to_string(items.size()) + "; expected " + kExpected);
    }
    return {items[0].real(kCoordinate_m), items[1].real(kCoordinate_m),
            items[2].real(kCoordinate_m)};
}

Bands read_shares(const JsonReader& json) {
    if (json.is_number()) return Bands::filled(json.real(kShare));
    constexpr const char* kExpected = "a number or a list of 8 numbers, 63 Hz to 8 kHz";
    const auto items = json.items(kExpected);
    if (items.size() != kBandCount) {
        json.fail("a list of " + std::to_string(items.size()) + "; expected " + kExpected);
    }
    Bands bands;
    for (std::size_t b = 0; b < kBandCount; ++b) bands[b] = items[b].real(kShare);
    return bands;
}

Material read_material(const std::string& name, const JsonReader& json) {
    json.allow_keys({"absorption", "scattering", "source"});
    Material material;
    material.name = name;
    material.absorption =
        read_shares(json.require("absorption", "a number or a list of 8 numbers from 0 to 1"));
    if (const auto scattering = json.find("scattering")) {
        material.scattering = read_shares(*scattering);
    }
    if (const auto source = json.find("source")) source->string("a text");
    return material;
}

Pose read_orientation(const JsonReader& json, const Vec3& position) {
    return {position, read_angle_rad(json, "yaw_deg"), read_angle_rad(json, "pitch_deg"),
            read_angle_rad(json, "roll_deg")};
}

Path read_path(const JsonReader& json) {
    json.allow_keys({"loop", "points"});
    Path path;
    if (const auto loop = json.find("loop")) path.loop = loop->boolean();
    constexpr const char* kExpected = "a list of points";
    const JsonReader points = json.require("points", kExpected);
    for (const JsonReader& item : points.items(kExpected)) {
        item.allow_keys({"t", "position", "yaw_deg", "pitch_deg", "roll_deg"});
        const JsonReader time = item.require("t", kTime_s.expected);
        const double time_s = time.number(kTime_s);
        if (!path.points.empty() && time_s < path.points.back().time_s) {
            time.fail("the time goes back; expected at least the time of the point before");
        }
        const Vec3 position = read_point(item.require("position", "a list of 3 numbers in metres"));
        path.points.push_back({time_s, read_orientation(item, position)});
    }
    if (path.points.empty()) points.fail("an empty path; expected at least one point");
    return path;
}

std::optional<Path> find_path(const JsonReader& json) {
    const auto path = json.find("path");
    return path ? std::optional(read_path(*path)) : std::nullopt;
}

}  // namespace aula
