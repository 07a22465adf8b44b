#include "apps/plugin/editor/room_sketch.h"

#include <chrono>
#include <exception>
#include <utility>

#include "apps/output/printable.h"
#include "aula/audio/realtime.h"
#include "aula/measurement.h"

namespace aula::plugin {

namespace {

/// Places that have not changed for so long stand still: the user has stopped dragging.
constexpr auto kStill = std::chrono::milliseconds(400);

/// Nice value, as of the rooms' threads.
constexpr int kNice = 10;

/// T30 to 5 %, the difference that listeners notice (ISO 3382-1, annex A), or what four seconds of
/// a processor give. The other parameters are not shown.
constexpr MeasurementLimits kLimits{.level_db = 1, .c80_db = 1, .t30 = 0.05, .edt = 0.1};
constexpr double kWork_s = 4;

bool are_equal(const RoomFiles& a, const RoomFiles& b) { return a.scene == b.scene; }

}  // namespace

RoomSketch::RoomSketch(std::size_t sources) : sources_(sources), thread_([this] { run(); }) {}

RoomSketch::~RoomSketch() {
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
    }
    changed_.notify_all();
    thread_.join();
}

void RoomSketch::show(const RoomFiles& files, const ControlValues& values) {
    const std::lock_guard lock(mutex_);
    if (!wanted_ || !are_equal(*wanted_, files)) {
        wanted_ = files;
        changed_.notify_all();
    }
    if (!room_) return;
    const Places places{room_->controls.source_pose(values, 0),
                        room_->controls.listener_pose(values)};
    if (places_ == places) return;
    places_ = places;
    is_measured_ = false;
    changed_.notify_all();
}

std::shared_ptr<const SketchedRoom> RoomSketch::room() const {
    const std::lock_guard lock(mutex_);
    return room_;
}

std::optional<ReverberationTimes> RoomSketch::times() const {
    const std::lock_guard lock(mutex_);
    return is_measured_ ? times_ : std::nullopt;
}

std::string RoomSketch::error() const {
    const std::lock_guard lock(mutex_);
    return error_;
}

void RoomSketch::run() {
    lower_priority(kNice);
    std::unique_lock lock(mutex_);
    while (!stop_) {
        const bool loads = wanted_ && !(loaded_ && are_equal(*wanted_, *loaded_));
        if (loads) {
            load(lock);
        } else if (room_ && places_ && !is_measured_) {
            const Places places = *places_;
            if (changed_.wait_for(lock, kStill, [&] { return stop_ || places_ != places; }))
                continue;
            measure(lock);
        } else {
            changed_.wait(lock);
        }
    }
}

void RoomSketch::load(std::unique_lock<std::mutex>& lock) {
    const RoomFiles files = *wanted_;
    lock.unlock();
    std::shared_ptr<const SketchedRoom> room;
    std::string error;
    // As the plugin does: the default room in place of one that cannot be read.
    for (const RoomFiles& readable : {files, RoomFiles{}}) {
        try {
            room = std::make_shared<SketchedRoom>(plugin_scene(readable), sources_);
            break;
        } catch (const std::exception& failure) {
            error = printable_line(failure.what());
        }
    }
    lock.lock();
    loaded_ = files;
    room_ = std::move(room);
    error_ = std::move(error);
    places_.reset();
    is_measured_ = false;
}

void RoomSketch::measure(std::unique_lock<std::mutex>& lock) {
    const std::shared_ptr<const SketchedRoom> room = room_;
    const Places places = *places_;
    lock.unlock();
    Scene scene = room->scene;
    scene.sources[0].set_pose(places.source);
    scene.listener.pose = places.listener;
    scene.listener.path.reset();
    scene.simulation.threads = 1;
    scene.simulation.waves_hz = 0;  // finding the modes takes longer than the rays
    const auto is_current = [&] {
        const std::lock_guard guard(mutex_);
        return !stop_ && room_ == room && places_ == places && are_equal(*wanted_, *loaded_);
    };
    ReverberationTimes times;
    bool ended = true;
    try {
        const auto measurement = aula::measure(
            scene, {.limits = kLimits, .max_work_s = kWork_s, .progress = [&](double) {
                        return is_current();
                    }});
        ended = measurement.has_value();
        if (ended) {
            constexpr auto kT30 = AcousticParameter::t30;
            const PairParameters& pair = measurement->parameters[0];
            for (std::size_t b = 0; b < kBandCount; ++b)
                times.octaves[b] = pair.octave(kT30, b).value;
            times.mid = pair.broadband[static_cast<std::size_t>(kT30)].value;
        }
    } catch (const std::exception&) {
        // A place out of the room, for instance: no times.
    }
    lock.lock();
    if (!ended || room_ != room || places_ != places) return;
    times_ = times;
    is_measured_ = true;
}

}  // namespace aula::plugin
