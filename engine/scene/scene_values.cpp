#include "engine/scene/scene_values.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <glm/trigonometric.hpp>

namespace aula {
namespace {

constexpr NumberRange kShare{0, 1, true, "a number from 0 to 1"};
constexpr NumberRange kAngle_deg{-1e6, 1e6, true, "degrees from -1e6 to 1e6"};
constexpr NumberRange kSoundReduction_db{0, Material::kHighestSoundReduction_db, true,
                                         "decibels from 0 to 120"};
constexpr NumberRange kTime_s{0, 1e9, true, "seconds from 0 to 1e9"};
constexpr NumberRange kCoordinate_m{-kLargestCoordinate_m, kLargestCoordinate_m, true,
                                    "metres from -1e6 to 1e6"};

float read_angle_rad(const JsonReader& json, const char* key) {
    float angle_rad = 0;
    json.read(key, [&](const JsonReader& x) { angle_rad = glm::radians(x.real(kAngle_deg)); });
    return angle_rad;
}

/// A number above 0 as text, rounded up to two significant digits, or to a tenth above 10.
std::string rounded_up(double x) {
    const int decimals = std::max(1, 1 - static_cast<int>(std::floor(std::log10(x))));
    const double scale = std::pow(10, decimals);
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%.*f", decimals, std::ceil(x * scale) / scale);
    return text.data();
}

/// Fails if a band transmits more than it absorbs.
void check_transmission(const Material& material, std::size_t band, const JsonReader& json) {
    if (!material.transmits_too_much(band)) return;
    const double transmitted = std::pow(10, -double{(*material.sound_reduction_db)[band]} / 10);
    const double absorption = double{material.absorption[band]};
    const double needed_db = absorption > 0 ? -10 * std::log10(absorption) : 1000;
    const std::string reduction = needed_db < double{Material::kHighestSoundReduction_db} - 1
                                      ? "at least " + rounded_up(needed_db) + " dB, or "
                                      : "";
    std::array<char, 32> share{};
    std::snprintf(share.data(), share.size(), "%.3g", absorption);
    json.fail("transmits " + rounded_up(transmitted) + " of the energy, more than the absorption " +
              share.data() + "; expected " + reduction + "absorption of at least " +
              rounded_up(transmitted));
}

/// The same for all bands; one error for a single number.
void check_transmission(const Material& material, const JsonReader& json) {
    if (json.is_number()) {
        // The band that transmits most of what is more than it absorbs.
        const auto excess = [&](std::size_t b) {
            return std::pow(10, -double{(*material.sound_reduction_db)[b]} / 10) -
                   double{material.absorption[b]};
        };
        std::size_t most = 0;
        for (std::size_t b = 1; b < kBandCount; ++b)
            if (excess(b) > excess(most)) most = b;
        return check_transmission(material, most, json);
    }
    const auto items = json.items("a list");
    for (std::size_t b = 0; b < kBandCount; ++b)
        items[b].attempt([&] { check_transmission(material, b, items[b]); });
}

}  // namespace

Bands read_bands(const JsonReader& json, const NumberRange& range, float on_error) {
    if (json.is_number()) return Bands::filled(json.real(range));
    constexpr const char* kExpected = "a number or a list of 8 numbers, 63 Hz to 8 kHz";
    const auto items = json.items(kExpected);
    if (items.size() != kBandCount) {
        json.fail("a list of " + std::to_string(items.size()) + "; expected " + kExpected);
    }
    Bands bands = Bands::filled(on_error);
    for (std::size_t b = 0; b < kBandCount; ++b)
        items[b].attempt([&] { bands[b] = items[b].real(range); });
    return bands;
}

Vec3 read_point(const JsonReader& json) {
    constexpr const char* kExpected = "a list of 3 numbers, x, y, z in metres";
    const auto items = json.items(kExpected);
    if (items.size() != 3) {
        json.fail("a list of " + std::to_string(items.size()) + "; expected " + kExpected);
    }
    Vec3 point(0);
    for (int axis = 0; axis < 3; ++axis) {
        const JsonReader& item = items[static_cast<std::size_t>(axis)];
        item.attempt([&] { point[axis] = item.real(kCoordinate_m); });
    }
    return point;
}

Material read_material(const std::string& name, const JsonReader& json,
                       const KnownMaterial& known) {
    json.allow_keys({"like", "absorption", "scattering", "sound_reduction_db", "source"});
    Material material;
    // Values after an error cause no further error.
    material.absorption = Bands::filled(1);
    const bool is_like = json.find("like").has_value();
    json.read("like", [&](const JsonReader& x) {
        if (!known) x.fail("is for materials of scenes; expected \"absorption\"");
        material = known(x);
    });
    material.name = name;
    json.attempt([&] {
        if (is_like && !json.find("absorption")) return;
        const JsonReader absorption =
            json.require("absorption", "a number or a list of 8 numbers from 0 to 1");
        material.absorption = read_bands(absorption, kShare, 1);
        if (material.sound_reduction_db && !json.find("sound_reduction_db"))
            check_transmission(material, absorption);
    });
    json.read("scattering",
              [&](const JsonReader& x) { material.scattering = read_bands(x, kShare, 0); });
    json.read("sound_reduction_db", [&](const JsonReader& x) {
        material.sound_reduction_db =
            read_bands(x, kSoundReduction_db, Material::kHighestSoundReduction_db);
        check_transmission(material, x);
    });
    json.read("source", [](const JsonReader& x) { x.string("a text"); });
    return material;
}

Pose read_orientation(const JsonReader& json, const Vec3& position) {
    return {position, read_angle_rad(json, "yaw_deg"), read_angle_rad(json, "pitch_deg"),
            read_angle_rad(json, "roll_deg")};
}

Trajectory read_trajectory(const JsonReader& json) {
    json.allow_keys({"loop", "points"});
    Trajectory path;
    json.read("loop", [&](const JsonReader& x) { path.loop = x.boolean(); });
    constexpr const char* kExpected = "a list of points";
    const JsonReader points = json.require("points", kExpected);
    for (const JsonReader& item : points.items(kExpected)) {
        const double before_s = path.points.empty() ? 0 : path.points.back().time_s;
        path.points.push_back({before_s, {}});
        Trajectory::Keyframe& point = path.points.back();
        item.attempt([&] {
            item.allow_keys({"t", "position", "yaw_deg", "pitch_deg", "roll_deg"});
            item.attempt([&] {
                const JsonReader time = item.require("t", kTime_s.expected);
                point.time_s = time.number(kTime_s);
                if (point.time_s < before_s) {
                    time.fail(
                        "the time decreases; expected at least the time of the previous point");
                }
            });
            Vec3 position(0);
            item.attempt([&] {
                position = read_point(item.require("position", "a list of 3 numbers in metres"));
            });
            point.pose = read_orientation(item, position);
        });
    }
    if (path.points.empty()) points.fail("an empty path; expected at least one point");
    return path;
}

std::optional<Trajectory> find_trajectory(const JsonReader& json) {
    const auto path = json.find("path");
    return path ? std::optional(read_trajectory(*path)) : std::nullopt;
}

}  // namespace aula
