#include "apps/room/remote/osc_remote.h"

#include <algorithm>
#include <numbers>
#include <optional>

#include "apps/room/remote/head_tracker.h"

namespace aula {

namespace {

std::optional<Vec3> point_of(const OscMessage& message, std::size_t first) {
    const auto x = message.number(first);
    const auto y = message.number(first + 1);
    const auto z = message.number(first + 2);
    if (!x || !y || !z) return std::nullopt;
    return Vec3(static_cast<float>(*x), static_cast<float>(*y), static_cast<float>(*z));
}

Vec3 radians_of(const Vec3& angles_deg) { return angles_deg * (std::numbers::pi_v<float> / 180); }

void turn(Pose& pose, const Vec3& angles_rad) {
    pose.yaw_rad = angles_rad.x;
    pose.pitch_rad = angles_rad.y;
    pose.roll_rad = angles_rad.z;
}

std::vector<std::string> names_of(const std::vector<Source>& sources) {
    std::vector<std::string> names;
    for (const Source& source : sources) names.push_back(source.name);
    return names;
}

}  // namespace

OscRemote::OscRemote(const OscOptions& options, Player& player, const Scene& scene)
    : options_(options),
      player_(player),
      names_(names_of(scene.sources)),
      adm_(scene, {scene, options}),
      input_(options.address, [this](const OscMessage& message) { handle(message); }),
      thread_([this] { run(); }) {}

OscRemote::~OscRemote() {
    stop_ = true;
    thread_.join();
}

void OscRemote::run() {
    constexpr int kWait_ms = 50;
    while (!stop_) input_.wait(kWait_ms);
}

void OscRemote::handle(const OscMessage& message) {
    if (message.address.starts_with("/aula/listener/")) return handle_listener(message);
    if (message.address.starts_with("/aula/source/")) return handle_source(message);
    if (message.address.starts_with("/adm/")) return handle_adm(message);
    if (message.address == "/aula/material") return handle_material(message);
    handle_head_tracker(message);
}

void OscRemote::handle_material(const OscMessage& message) {
    const std::string* from = message.text(0);
    const std::string* to = message.text(1);
    if (from == nullptr || to == nullptr) return;
    constexpr std::size_t kMax = 64;
    const std::lock_guard lock(mutex_);
    // If a material is replaced repeatedly between two calls, the newest replacement counts.
    const auto same = std::find_if(materials_.begin(), materials_.end(),
                                   [&](const auto& change) { return change.first == *from; });
    if (same != materials_.end()) materials_.erase(same);
    if (materials_.size() < kMax) materials_.emplace_back(*from, *to);
}

void OscRemote::handle_listener(const OscMessage& message) {
    if (message.address == "/aula/listener/path") {
        player_.adjust([](PlayControls& controls, const Pose&) { controls.listener.reset(); });
        return;
    }
    const bool whole = message.address == "/aula/listener/pose";
    const auto position =
        whole || message.address == "/aula/listener/position" ? point_of(message, 0) : std::nullopt;
    const auto angles_deg = whole                                             ? point_of(message, 3)
                            : message.address == "/aula/listener/orientation" ? point_of(message, 0)
                                                                              : std::nullopt;
    if (whole ? !position || !angles_deg : !position && !angles_deg) return;
    player_.adjust([&](PlayControls& controls, const Pose& now) {
        Pose pose = controls.listener.value_or(now);
        if (position) pose.position = *position;
        if (angles_deg) turn(pose, radians_of(*angles_deg));
        controls.listener = pose;
    });
}

void OscRemote::handle_source(const OscMessage& message) {
    const std::string* name = message.text(0);
    if (name == nullptr) return;
    std::size_t source = 0;
    {
        const std::lock_guard lock(mutex_);
        source = static_cast<std::size_t>(std::find(names_.begin(), names_.end(), *name) -
                                          names_.begin());
        if (source == names_.size()) return;
    }
    player_.adjust([&](PlayControls& controls, const Pose&) {
        if (controls.sources.size() <= source) controls.sources.resize(source + 1);
        SourceControl& control = controls.sources[source];
        if (message.address == "/aula/source/position") {
            if (const auto position = point_of(message, 1)) control.position = position;
        } else if (message.address == "/aula/source/orientation") {
            if (const auto angles_deg = point_of(message, 1))
                control.angles_rad = radians_of(*angles_deg);
        } else if (message.address == "/aula/source/pose") {
            const auto position = point_of(message, 1);
            const auto angles_deg = point_of(message, 4);
            if (!position || !angles_deg) return;
            control.position = position;
            control.angles_rad = radians_of(*angles_deg);
        } else if (message.address == "/aula/source/gain") {
            constexpr double kMax_db = 60;
            if (const auto gain_db = message.number(1); gain_db && *gain_db <= kMax_db)
                control.gain_db = static_cast<float>(*gain_db);
        } else if (message.address == "/aula/source/mute") {
            if (const auto muted = message.number(1)) control.muted = *muted != 0;
        }
    });
}

void OscRemote::handle_adm(const OscMessage& message) {
    constexpr int kAnswerPort = 4002;
    PresentPoses present{.listener = {}, .sources = player_.source_positions()};
    std::vector<OscAnswer> answers;
    {
        const std::lock_guard lock(mutex_);
        player_.adjust([&](PlayControls& controls, const Pose& listener) {
            present.listener = listener;
            answers = adm_.handle(message, controls, present);
        });
    }
    if (message.sender.empty()) return;
    for (const OscAnswer& answer : answers) input_.send(message.sender, kAnswerPort, answer);
}

void OscRemote::handle_head_tracker(const OscMessage& message) {
    const auto angles_rad = head_angles_rad(message, options_.head_invert);
    if (!angles_rad) return;
    player_.adjust([&](PlayControls& controls, const Pose& now) {
        Pose pose = controls.listener.value_or(now);
        turn(pose, *angles_rad);
        controls.listener = pose;
    });
}

void OscRemote::set_scene(const Scene& scene) {
    const std::lock_guard lock(mutex_);
    names_ = names_of(scene.sources);
    adm_ = AdmOsc(scene, {scene, options_});
}

std::string OscRemote::region_text() const {
    const std::lock_guard lock(mutex_);
    return adm_.region().text();
}

std::vector<std::pair<std::string, std::string>> OscRemote::take_materials() {
    const std::lock_guard lock(mutex_);
    return std::exchange(materials_, {});
}

}  // namespace aula
