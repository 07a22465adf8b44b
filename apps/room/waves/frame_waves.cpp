#include "apps/room/waves/frame_waves.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <glm/geometric.hpp>
#include <utility>

#include "aula/audio/realtime.h"

namespace aula {

namespace {

/// While objects move, modes are found at this interval at most: a search of 0.15 s begins as soon
/// as the one before it has ended, and a movement is heard within 0.3 s.
constexpr double kFollow_s = 0.15;

/// Modes of another room are looked for where a source without them has moved by more than this, at
/// this interval: a source that moves in the open costs little.
constexpr float kSameRoom_m = 1;
constexpr double kNewRoom_s = 2;

/// The pose of an object becomes its geometry.
void fix(Object& object, const RigidTransform& transform) {
    object.vertices = object.world_vertices(transform);
    object.translation = Vec3(0);
    object.path.reset();
    object.movable = false;
}

}  // namespace

FrameWaves::FrameWaves(const Scene& scene, WavesReady ready) : ready_(ready) {
    if (scene.simulation.waves_hz > 0) scene_ = scene;
}

void FrameWaves::set_object_material(std::size_t object, const Material& material) {
    if (!scene_) return;
    const auto [own, is_new] =
        own_materials_.try_emplace(object, static_cast<std::uint32_t>(scene_->materials.size()));
    if (is_new) {
        scene_->materials.push_back(material);
        std::vector<std::uint32_t>& of_triangles = scene_->objects[object].triangle_materials;
        std::fill(of_triangles.begin(), of_triangles.end(), own->second);
    }
    change_material(own->second, material);
}

void FrameWaves::change_material(std::size_t material, const Material& coefficients) {
    if (!scene_) return;
    scene_->materials[material] = coefficients;
    is_old_ = true;
}

void FrameWaves::begin_frame(double time_s, std::span<const Vec3> sources,
                             std::span<const RigidTransform> objects) {
    if (!scene_) return;
    objects_.resize(scene_->objects.size());
    for (std::size_t i = 0; i < objects_.size(); ++i) {
        const Object& object = scene_->objects[i];
        if (!object.moves()) continue;
        const RigidTransform now = objects.empty() ? object.transform_at(time_s) : objects[i];
        if (!(now == objects_[i])) is_old_ = true;
        objects_[i] = now;
    }
    if (search_.valid() && search_.wait_for(std::chrono::seconds(0)) == std::future_status::ready)
        join_ = search_.get();
    const auto is_within = [&](double interval_s) {
        return join_ && time_s >= found_s_ && time_s < found_s_ + interval_s;
    };
    if (!is_within(kNewRoom_s)) {
        is_old_ = is_old_ || !std::all_of(sources.begin(), sources.end(),
                                          [this](const Vec3& place) { return is_known(place); });
    }
    if (!is_old_ || search_.valid() || is_within(kFollow_s)) return;
    found_s_ = time_s;
    places_.assign(sources.begin(), sources.end());
    is_old_ = false;
    find();
}

/// True if a source is in a room whose modes are known, or near a place where there are none.
bool FrameWaves::is_known(const Vec3& source) const {
    if (join_ && join_->room_at(source) != nullptr) return true;
    return std::any_of(places_.begin(), places_.end(), [&](const Vec3& place) {
        return glm::distance(place, source) < kSameRoom_m;
    });
}

void FrameWaves::find() {
    Scene room = *scene_;
    for (std::size_t i = 0; i < room.objects.size(); ++i)
        if (room.objects[i].moves()) fix(room.objects[i], objects_[i]);
    room.sources.clear();
    for (const Vec3& place : places_) room.sources.emplace_back().position = place;
    if (ready_ == WavesReady::at_once) {
        join_ = std::make_shared<const WaveJoin>(room, join_.get());
        return;
    }
    room.simulation.threads = 1;
    search_ = std::async(std::launch::async,
                         [room = std::move(room), before = join_,
                          stop = stop_.get_token()]() -> std::shared_ptr<const WaveJoin> {
                             lower_priority(kPropagationNice);
                             try {
                                 return std::make_shared<const WaveJoin>(room, before.get(), stop);
                             } catch (const std::exception&) {
                                 // Without memory for modes rays are alone.
                                 return nullptr;
                             }
                         });
}

std::optional<PairWaves> FrameWaves::pair(const Vec3& source, const Vec3& receiver,
                                          const EnergyResponse& rays) const {
    if (!join_) return {};
    return join_->pair(source, receiver, rays);
}

}  // namespace aula
