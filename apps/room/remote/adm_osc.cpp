#include "apps/room/remote/adm_osc.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "engine/scene/scene_values.h"

namespace aula {

namespace {

using DVec3 = glm::dvec3;

constexpr double kDegree = std::numbers::pi / 180;

/// Steps of a pattern's comparison.
constexpr int kMaxSteps = 1000;

bool matches_class(std::string_view set, char c) {
    const bool negated = set.starts_with('!');
    if (negated) set.remove_prefix(1);
    bool found = false;
    for (std::size_t i = 0; i < set.size(); ++i) {
        if (i + 2 < set.size() && set[i + 1] == '-') {
            found |= c >= set[i] && c <= set[i + 2];
            i += 2;
        } else {
            found |= c == set[i];
        }
    }
    return found != negated;
}

bool matches(std::string_view pattern, std::string_view text, int& steps) {
    while (true) {
        if (++steps > kMaxSteps) return false;
        if (pattern.empty()) return text.empty();
        const char first = pattern[0];
        if (first == '*') {
            for (std::size_t n = 0; n <= text.size(); ++n)
                if (matches(pattern.substr(1), text.substr(n), steps)) return true;
            return false;
        }
        if (first == '{') {
            const std::size_t end = pattern.find('}');
            if (end == std::string_view::npos) return false;
            for (std::size_t begin = 1; begin <= end;) {
                const std::size_t comma = std::min(pattern.find(',', begin), end);
                const std::string_view word = pattern.substr(begin, comma - begin);
                if (text.starts_with(word) &&
                    matches(pattern.substr(end + 1), text.substr(word.size()), steps))
                    return true;
                begin = comma + 1;
            }
            return false;
        }
        if (text.empty()) return false;
        std::size_t used = 1;
        if (first == '[') {
            const std::size_t end = pattern.find(']');
            if (end == std::string_view::npos) return false;
            if (!matches_class(pattern.substr(1, end - 1), text[0])) return false;
            used = end + 1;
        } else if (first != '?' && first != text[0]) {
            return false;
        }
        pattern.remove_prefix(used);
        text.remove_prefix(1);
    }
}

/// Coordinates of ADM-OSC for an offset from the origin in Aula's axes.
DVec3 adm_of(const Vec3& offset_m, float radius_m) {
    return DVec3(-offset_m.y, offset_m.x, offset_m.z) / static_cast<double>(radius_m);
}

/// The position in Aula's axes, within the coordinates that a scene may have.
Vec3 position_of(const DVec3& adm, const Vec3& origin, float radius_m) {
    const Vec3 offset(static_cast<float>(adm.y), static_cast<float>(-adm.x),
                      static_cast<float>(adm.z));
    return glm::clamp(origin + offset * radius_m, -kLargestCoordinate_m, kLargestCoordinate_m);
}

/// Azimuth and elevation in degrees, and distance. `known_deg`: angles of a point that has none.
DVec3 polar_of(const DVec3& adm, const DVec3& known_deg) {
    constexpr double kPoint = 1e-6;
    const double distance = glm::length(adm);
    const double horizontal = std::hypot(adm.x, adm.y);
    DVec3 polar(known_deg.x, known_deg.y, distance);
    if (distance > kPoint) polar.y = std::atan2(adm.z, horizontal) / kDegree;
    if (horizontal > kPoint) polar.x = std::atan2(-adm.x, adm.y) / kDegree;
    return polar;
}

DVec3 cartesian_of(const DVec3& polar) {
    const double azimuth_rad = polar.x * kDegree;
    const double elevation_rad = polar.y * kDegree;
    return polar.z * DVec3(-std::sin(azimuth_rad) * std::cos(elevation_rad),
                           std::cos(azimuth_rad) * std::cos(elevation_rad),
                           std::sin(elevation_rad));
}

/// A parameter that sets some components of a point, in their order.
struct PointParameter {
    std::string_view name;
    std::vector<int> components;
};

const std::array kCartesian = {PointParameter{"xyz", {0, 1, 2}}, PointParameter{"xy", {0, 1}},
                               PointParameter{"x", {0}}, PointParameter{"y", {1}},
                               PointParameter{"z", {2}}};
const std::array kPolar = {PointParameter{"aed", {0, 1, 2}}, PointParameter{"azim", {0}},
                           PointParameter{"elev", {1}}, PointParameter{"dist", {2}}};

template <typename Parameters>
const PointParameter* find(const Parameters& parameters, std::string_view name) {
    const auto found = std::find_if(parameters.begin(), parameters.end(),
                                    [&](const PointParameter& p) { return p.name == name; });
    return found != parameters.end() ? &*found : nullptr;
}

/// Sets the components that a parameter has; false, and unspecified, if an argument is missing.
bool set_components(const PointParameter& parameter, const OscMessage& message, const DVec3& min,
                    const DVec3& max, DVec3& point) {
    for (std::size_t i = 0; i < parameter.components.size(); ++i) {
        const int component = parameter.components[i];
        const auto value = message.clamped(i, min[component], max[component]);
        if (!value) return false;
        point[component] = *value;
    }
    return true;
}

OscAnswer point_answer(const std::string& address, const PointParameter& parameter,
                       const DVec3& point) {
    OscAnswer answer{{.address = address}, std::string(parameter.components.size(), 'f')};
    for (const int component : parameter.components)
        answer.message.arguments.emplace_back(point[component]);
    return answer;
}

const DVec3 kCube(1);
const DVec3 kLowestPolar(-180, -90, 0);
const DVec3 kHighestPolar(180, 90, 1);
const DVec3 kTurns_deg(180);

}  // namespace

bool matches(std::string_view pattern, std::string_view text) {
    int steps = 0;
    return matches(pattern, text, steps);
}

AdmOsc::AdmOsc(const Scene& scene, const AdmRegion& region) : region_(region) {
    for (const Source& source : scene.sources) {
        objects_.push_back(
            {.gain_db = source.gain_db, .name = source.name, .radius_m = region.radius_m});
        initial_positions_.push_back(source.position_at(0));
    }
}

std::vector<OscAnswer> AdmOsc::handle(const OscMessage& message, PlayControls& controls,
                                      const PresentPoses& present) {
    constexpr std::string_view kObjects = "/adm/obj/";
    const std::string_view address = message.address;
    if (address.starts_with("/adm/lis/")) return handle_listener(message, controls, present);
    if (!address.starts_with(kObjects)) return {};
    const std::string_view rest = address.substr(kObjects.size());
    const std::size_t slash = rest.find('/');
    if (slash == std::string_view::npos) return {};
    const std::string_view pattern = rest.substr(0, slash);
    const std::string_view parameter = rest.substr(slash + 1);
    std::vector<OscAnswer> answers;
    for (std::size_t object = 0; object < objects_.size(); ++object) {
        const std::string number = std::to_string(object + 1);
        if (!matches(pattern, number)) continue;
        SourceControl control = controls.source(object);
        const Vec3 position = control.position                  ? *control.position
                              : object < present.sources.size() ? present.sources[object]
                                                                : initial_positions_[object];
        if (message.arguments.empty()) {
            const std::string own = std::string(kObjects) + number + "/" + std::string(parameter);
            if (auto found = answer(object, own, parameter, control, position))
                answers.push_back(std::move(*found));
            continue;
        }
        change(object, parameter, message, control, position);
        if (controls.sources.size() <= object) controls.sources.resize(object + 1);
        controls.sources[object] = control;
    }
    return answers;
}

void AdmOsc::change(std::size_t object, std::string_view parameter, const OscMessage& message,
                    SourceControl& control, const Vec3& position) {
    AdmObject& known = objects_[object];
    const DVec3 adm = adm_of(position - region_.origin, known.radius_m);
    const auto place = [&](const DVec3& at) {
        control.position = position_of(at, region_.origin, known.radius_m);
    };
    if (const PointParameter* cartesian = find(kCartesian, parameter)) {
        DVec3 point = adm;
        if (set_components(*cartesian, message, -kCube, kCube, point)) place(point);
    } else if (const PointParameter* polar = find(kPolar, parameter)) {
        DVec3 point = polar_of(adm, {known.azimuth_deg, known.elevation_deg, 0});
        if (!set_components(*polar, message, kLowestPolar, kHighestPolar, point)) return;
        known.azimuth_deg = point.x;
        known.elevation_deg = point.y;
        place(cartesian_of(point));
    } else if (parameter == "gain") {
        constexpr double kHighestGain = 1000;  // 60 dB
        if (const auto gain = message.clamped(0, 0, kHighestGain))
            control.gain_db = static_cast<float>(20 * std::log10(*gain));
    } else if (parameter == "mute") {
        if (const auto muted = message.clamped(0, 0, 1)) control.muted = *muted >= 0.5;
    } else if (parameter == "dmax") {
        constexpr double kShortest_m = 0.01;
        constexpr double kLongest_m = 1e6;
        const auto radius_m = message.clamped(0, kShortest_m, kLongest_m);
        if (!radius_m) return;
        known.radius_m = static_cast<float>(*radius_m);
        place(adm);
    } else if (parameter == "name") {
        constexpr std::size_t kLongest = 128;
        if (const std::string* name = message.text(0)) known.name = name->substr(0, kLongest);
    }
}

std::optional<OscAnswer> AdmOsc::answer(std::size_t object, const std::string& address,
                                        std::string_view parameter, const SourceControl& control,
                                        const Vec3& position) const {
    const AdmObject& known = objects_[object];
    const DVec3 adm = adm_of(position - region_.origin, known.radius_m);
    if (const PointParameter* cartesian = find(kCartesian, parameter))
        return point_answer(address, *cartesian, adm);
    if (const PointParameter* polar = find(kPolar, parameter))
        return point_answer(address, *polar,
                            polar_of(adm, {known.azimuth_deg, known.elevation_deg, 0}));
    if (parameter == "gain") {
        const auto gain_db = static_cast<double>(control.gain_db.value_or(known.gain_db));
        return OscAnswer{{address, {std::pow(10.0, gain_db / 20)}}, "f"};
    }
    if (parameter == "mute") return OscAnswer{{address, {control.muted ? 1.0 : 0.0}}, "i"};
    if (parameter == "dmax") return OscAnswer{{address, {double{known.radius_m}}}, "f"};
    if (parameter == "name") return OscAnswer{{address, {known.name}}, "s"};
    return std::nullopt;
}

std::vector<OscAnswer> AdmOsc::handle_listener(const OscMessage& message, PlayControls& controls,
                                               const PresentPoses& present) const {
    const bool moves = message.address == "/adm/lis/xyz";
    if (!moves && message.address != "/adm/lis/ypr") return {};
    Pose pose = controls.listener.value_or(present.listener);
    DVec3 point = moves ? adm_of(pose.position - region_.origin, region_.radius_m)
                        : DVec3(pose.yaw_rad, pose.pitch_rad, pose.roll_rad) / kDegree;
    const PointParameter& all = kCartesian[0];
    if (message.arguments.empty()) return {point_answer(message.address, all, point)};
    const DVec3& largest = moves ? kCube : kTurns_deg;
    if (!set_components(all, message, -largest, largest, point)) return {};
    if (moves) {
        pose.position = position_of(point, region_.origin, region_.radius_m);
    } else {
        pose.yaw_rad = static_cast<float>(point.x * kDegree);
        pose.pitch_rad = static_cast<float>(point.y * kDegree);
        pose.roll_rad = static_cast<float>(point.z * kDegree);
    }
    controls.listener = pose;
    return {};
}

}  // namespace aula
