#include "apps/plugin/plugin_room.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numbers>
#include <thread>
#include <utility>

#include "apps/plugin/default_room.h"
#include "aula/engine/scene_file.h"

namespace aula::plugin {

namespace {

/// Distance of the two sources of a stereo input, m: a choice, that of near loudspeakers.
constexpr float kStereoWidth_m = 1;

/// Distance of the ends of a room from its box, m: a head, which does not enter a wall.
constexpr float kFromWall_m = 0.1F;

float radians(float degrees) { return degrees * std::numbers::pi_v<float> / 180; }

/// Whether controls from `first` on have their initial values.
bool are_initial(const ControlValues& values, Control first, std::size_t count) {
    const auto begin = static_cast<std::size_t>(first);
    for (std::size_t i = begin; i < begin + count; ++i)
        if (values[i] != control_infos()[i].initial) return false;
    return true;
}

/// Whether controls from `first` on are equal.
bool are_equal(const ControlValues& a, const ControlValues& b, Control first, std::size_t count) {
    const auto begin = static_cast<std::ptrdiff_t>(first);
    return std::equal(a.begin() + begin, a.begin() + begin + static_cast<std::ptrdiff_t>(count),
                      b.begin() + begin);
}

Vec3 position(const ControlValues& values, Control first) {
    const auto i = static_cast<std::size_t>(first);
    return {values[i], values[i + 1], values[i + 2]};
}

/// Where a share of -1 or 1 moves a coordinate, in a room from `low` to `high`. Nothing moves away
/// from an end that it is beyond.
float end_of(float place, bool is_high, float low, float high) {
    const float inset = std::min(kFromWall_m, (high - low) / 2);
    return is_high ? std::max(high - inset, place) : std::min(low + inset, place);
}

/// The share that moves a coordinate from `place` to `wanted`, or as near as possible.
float share_of(float place, float wanted, float low, float high) {
    const bool is_high = wanted > place;
    const float way = std::abs(end_of(place, is_high, low, high) - place);
    if (way == 0) return 0;
    const float share = std::min(std::abs(wanted - place) / way, 1.0F);
    return is_high ? share : -share;
}

/// Rays of a quality per ray of the scene.
float rays_factor(float quality) { return std::pow(4.0F, std::round(quality) - 1); }

AuralizerOptions auralizer_options(const PluginPorts& ports, RenderClock clock) {
    AuralizerOptions options{ports};
    options.clock = clock;
    options.sample_by_sample = true;
    options.max_sources = ports.sources;
    return options;
}

/// The scene of an instance, with a source for each input. Its control sets the rays, on the exact
/// clock, too.
Scene instance_scene(Scene scene, std::size_t sources) {
    scene.simulation.rays = scene.simulation.ray_count();
    const SceneControls controls(scene, sources);
    for (std::size_t s = 0; s < sources; ++s) {
        if (s > 0) {
            scene.sources.push_back(scene.sources[0]);
            scene.sources[s].name += " " + std::to_string(s + 1);
        }
        scene.sources[s].set_pose(controls.source_pose(initial_values(), s));
    }
    return scene;
}

/// In real time one thread traces: a host runs many instances.
Scene live_scene(Scene scene, GrowingLength& length) {
    scene.simulation.threads = 1;
    length.fit(scene, room_length_s(scene));
    return scene;
}

/// Follows the controls, and measures the frames.
AuralizerOptions live_options(const Scene& scene, std::size_t sources, AuralizerOptions options,
                              std::shared_ptr<const ControlSnapshot> controls,
                              const ReportRays& report, GrowingLength& length,
                              std::function<void()> replace) {
    options.before_frame = [follower = ControlFollower(scene, sources), load = RayLoad(report),
                            controls = std::move(controls), &length, replace = std::move(replace)](
                               Auralizer& auralizer, double /*time_s*/) mutable {
        const ControlValues values = controls->read();
        follower.follow(auralizer, values);
        const AuralizerStatus now = auralizer.status();
        const double took_s = now.frame_ms / 1000;
        const double period_s = now.frame_period_ms / 1000;
        auralizer.set_rays(load.next(follower.rays(values), took_s, period_s));
        if (now.frames > 0 && length.add(took_s, period_s)) replace();
    };
    return options;
}

}  // namespace

Scene plugin_scene(const RoomFiles& files) {
    Scene scene = files.scene.empty() ? default_room() : load_scene(files.scene).scene;
    scene.sources.resize(1);
    scene.sources[0].set_pose(scene.sources[0].pose_at(0));
    scene.sources[0].path.reset();
    scene.listener.pose = scene.listener.pose_at(0);
    scene.listener.path.reset();
    if (files.seed) scene.simulation.seed = *files.seed;
    return scene;
}

ControlValues initial_values() {
    ControlValues values;
    for (std::size_t i = 0; i < kControls; ++i) values[i] = control_infos()[i].initial;
    return values;
}

SceneControls::SceneControls(const Scene& scene, std::size_t sources)
    : sources_(sources),
      room_(geometry_bounds(scene.objects)),
      scene_source_(scene.sources[0].pose_at(0)),
      scene_listener_(scene.listener.pose),
      scene_gain_db_(scene.sources[0].gain_db),
      scene_rays_(scene.simulation.ray_count()) {}

/// The place before the shares of the room: that of three controls or of the scene.
Vec3 SceneControls::in_metres(const ControlValues& values, Control first) const {
    if (!are_initial(values, first, 3)) return position(values, first);
    return first == Control::source_x ? scene_source_.position : scene_listener_.position;
}

/// A place moved by the three shares from `first` on. Without geometry there is no room.
Vec3 SceneControls::in_room(Vec3 place, const ControlValues& values, Control first) const {
    if (!has_room()) return place;
    const Vec3 shares = position(values, first);
    for (int axis = 0; axis < 3; ++axis) {
        const float end = end_of(place[axis], shares[axis] > 0, room_.min[axis], room_.max[axis]);
        place[axis] = std::lerp(place[axis], end, std::abs(shares[axis]));
    }
    return place;
}

Pose SceneControls::source_pose(const ControlValues& values, std::size_t source) const {
    Pose pose = scene_source_;
    pose.position = in_room(in_metres(values, Control::source_x), values, Control::source_room_x);
    const float yaw = radians(value_of(values, Control::source_yaw));
    pose.yaw_rad += yaw;
    if (sources_ == 2) {
        const float left_m = source == 0 ? kStereoWidth_m / 2 : -kStereoWidth_m / 2;
        pose.position += left_m * Vec3(-std::sin(double{yaw}), std::cos(double{yaw}), 0);
    }
    return pose;
}

Pose SceneControls::listener_pose(const ControlValues& values) const {
    Pose pose = scene_listener_;
    pose.position =
        in_room(in_metres(values, Control::listener_x), values, Control::listener_room_x);
    if (!are_initial(values, Control::listener_yaw, 3)) {
        pose.yaw_rad = radians(value_of(values, Control::listener_yaw));
        pose.pitch_rad = radians(value_of(values, Control::listener_pitch));
        pose.roll_rad = radians(value_of(values, Control::listener_roll));
    }
    return pose;
}

std::array<std::pair<Control, float>, 3> SceneControls::moved_to(
    const Vec3& place, Control first, const ControlValues& values) const {
    const bool is_source = first == Control::source_x;
    const Control shares = is_source ? Control::source_room_x : Control::listener_room_x;
    const auto begin = static_cast<std::size_t>(has_room() ? shares : first);
    const Vec3 from = in_metres(values, first);
    std::array<std::pair<Control, float>, 3> moved;
    for (int axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<std::size_t>(axis);
        const float value =
            has_room() ? share_of(from[axis], place[axis], room_.min[axis], room_.max[axis])
                       : place[axis];
        moved[i] = {static_cast<Control>(begin + i), value};
    }
    return moved;
}

float SceneControls::gain_db(const ControlValues& values) const {
    return scene_gain_db_ + value_of(values, Control::gain_db);
}

int SceneControls::rays(const ControlValues& values) const {
    const float rays =
        static_cast<float>(scene_rays_) * rays_factor(value_of(values, Control::quality));
    return std::clamp(static_cast<int>(rays), 1, Simulation::kMaxRays);
}

PartGains SceneControls::part_gains(const ControlValues& values) {
    const auto gain = [&](Control part) { return value_of(values, part) > 0.5F ? 1.0F : 0.0F; };
    return {.direct = gain(Control::direct),
            .early = gain(Control::early),
            .late = gain(Control::late)};
}

ControlFollower::ControlFollower(const Scene& scene, std::size_t sources)
    : controls_(scene, sources), applied_(initial_values()) {}

void ControlFollower::follow(Auralizer& auralizer, const ControlValues& values) {
    const auto differ = [&](Control first, std::size_t count) {
        return !are_equal(values, applied_, first, count);
    };
    const bool sources_move = differ(Control::source_x, 3) || differ(Control::source_yaw, 1) ||
                              differ(Control::source_room_x, 3);
    for (std::size_t s = 0; s < controls_.sources(); ++s) {
        const SourceId id = source_id(s);
        if (sources_move) auralizer.set_source(id, controls_.source_pose(values, s));
        if (differ(Control::gain_db, 1)) auralizer.set_gain(id, controls_.gain_db(values));
    }
    if (differ(Control::listener_x, 6) || differ(Control::listener_room_x, 3))
        auralizer.set_listener(controls_.listener_pose(values));
    if (differ(Control::direct, 3)) auralizer.set_part_gains(controls_.part_gains(values));
    if (differ(Control::quality, 1)) auralizer.set_rays(controls_.rays(values));
    applied_ = values;
}

OwnRoom::OwnRoom(const Scene& scene, const PluginPorts& ports)
    : follower_(scene, ports.sources),
      auralizer_(instance_scene(scene, ports.sources),
                 auralizer_options(ports, RenderClock::exact)) {}

OwnRoom::OwnRoom(const Scene& scene, const PluginPorts& ports,
                 std::shared_ptr<const ControlSnapshot> controls, const ReportRays& report,
                 std::shared_ptr<GrowingLength> length, std::function<void()> replace)
    : length_(std::move(length)),
      heard_(length_->hear()),
      follower_(scene, ports.sources),
      auralizer_(
          live_scene(instance_scene(scene, ports.sources), *length_),
          live_options(scene, ports.sources, auralizer_options(ports, RenderClock::real_time),
                       std::move(controls), report, *length_, std::move(replace))) {}

void OwnRoom::wait_for_frame() const {
    using namespace std::chrono_literals;
    const auto end = std::chrono::steady_clock::now() + 5s;
    while (auralizer_.status().frames == 0 && std::chrono::steady_clock::now() < end)
        std::this_thread::sleep_for(1ms);
}

void OwnRoom::render(std::span<const float* const> inputs, std::span<float* const> outputs,
                     int samples) {
    std::array<SourceSignal, kMostSources> signals;
    for (std::size_t s = 0; s < inputs.size(); ++s) signals[s] = {source_id(s), inputs[s]};
    auralizer_.render(std::span(signals).first(inputs.size()), outputs, samples);
}

}  // namespace aula::plugin
