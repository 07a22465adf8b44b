#include "apps/plugin/shared_room.h"

#include <algorithm>
#include <array>
#include <cfenv>
#include <chrono>
#include <future>
#include <glm/geometric.hpp>
#include <map>
#include <span>
#include <system_error>
#include <utility>

#include "apps/plugin/group_voice.h"
#include "aula/audio/realtime.h"
#include "aula/exception.h"

namespace aula::plugin {

namespace {

namespace fs = std::filesystem;

/// An instance that is elsewhere for so many frames leaves: 0.1 s at 30 Hz. Hosts call instances
/// one after another, so that a common movement reaches some of them a block later.
constexpr int kFramesElsewhere = 3;

/// While listeners move, those within this distance of each other are in one place.
constexpr float kSamePlace_m = 0.1F;

/// Two rooms of a group whose listeners are at one place for so long become one.
constexpr auto kStill = std::chrono::seconds(1);

constexpr auto kLongestWait = std::chrono::seconds(5);

/// The present version; none if the file cannot be found.
std::optional<FileVersion> version_of(const fs::path& file) {
    std::error_code error;
    FileVersion version{file, fs::last_write_time(file, error)};
    if (!error) version.bytes = fs::file_size(file, error);
    if (error) return std::nullopt;
    return version;
}

}  // namespace

GroupKey::GroupKey(const RoomFiles& files, int group_number)
    : scene(files.scene), seed(files.seed), group(group_number) {
    if (scene.empty()) return;
    std::error_code error;
    scene = fs::canonical(files.scene, error);
    if (error) throw InputError(files.scene.string() + ": " + error.message());
}

GroupKey GroupKey::with_versions(const Scene& read) const {
    std::vector<fs::path> files;
    if (!scene.empty()) files.push_back(scene);
    for (const Object& object : read.objects)
        files.insert(files.end(), object.files.begin(), object.files.end());
    for (const Source& source : read.sources)
        if (!source.directivity_file.empty()) files.push_back(source.directivity_file);
    GroupKey key = *this;
    for (const fs::path& file : files)
        key.versions.push_back(version_of(file).value_or(FileVersion{file}));
    return key;
}

bool GroupKey::matches(const GroupKey& room) const {
    return scene == room.scene && seed == room.seed && group == room.group &&
           std::all_of(room.versions.begin(), room.versions.end(), [](const FileVersion& version) {
               return version_of(version.file) == version;
           });
}

struct SharedRoom::Register {
    std::mutex mutex;
    std::map<GroupKey, std::vector<std::weak_ptr<Entry>>> rooms;
    std::uint64_t last_number = 0;
};

// Never destroyed: a host may end while propagation threads run.
SharedRoom::Register& SharedRoom::all() {
    static Register& rooms = *new Register;
    return rooms;
}

class SharedRoom::Turn {
 public:
    explicit Turn(SharedRoom& room) : room_(room) {
        ++room_.waiting_;
        lock_ = std::unique_lock(room_.mutex_);
    }
    ~Turn() { end(); }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

    void end() {
        if (std::exchange(ended_, true)) return;
        --room_.waiting_;
        room_.changed_.notify_all();
    }
    std::unique_lock<std::mutex>& lock() { return lock_; }

 private:
    SharedRoom& room_;
    std::unique_lock<std::mutex> lock_;
    bool ended_ = false;
};

std::shared_ptr<SharedRoom> SharedRoom::join(const GroupKey& key, const ControlValues& values,
                                             const std::function<Scene()>& load) {
    // Destroyed after the lock: this may be the last owner of one of them.
    std::vector<std::shared_ptr<SharedRoom>> alive;
    Register& present = all();
    const std::lock_guard lock(present.mutex);
    for (auto& [other_key, rooms] : present.rooms)
        std::erase_if(rooms, [](const auto& entry) { return entry.expired(); });
    std::erase_if(present.rooms, [](const auto& rooms) { return rooms.second.empty(); });
    for (const auto& [other_key, rooms] : present.rooms) {
        if (!key.matches(other_key)) continue;
        for (const std::weak_ptr<Entry>& weak : rooms) {
            const std::shared_ptr<Entry> entry = weak.lock();
            if (!entry) continue;
            const std::lock_guard entry_lock(entry->mutex);
            auto room = entry->room.lock();
            if (!room) continue;
            alive.push_back(room);
            const Vec3 place = SceneControls(room->scene_, 1).listener_pose(values).position;
            if (entry->open && entry->place == place) return room;
        }
    }
    // All rooms of a group have the scene of the first one.
    Scene scene = alive.empty() ? load() : alive[0]->scene_;
    const GroupKey versions = alive.empty() ? key.with_versions(scene) : alive[0]->key_;
    const Vec3 place = SceneControls(scene, 1).listener_pose(values).position;
    const std::shared_ptr<SharedRoom> room(new SharedRoom(
        versions, std::move(scene), place, alive.empty() ? nullptr : alive[0].get()));
    room->entry_->number = ++present.last_number;
    room->entry_->room = room;
    present.rooms[versions].push_back(room->entry_);
    return room;
}

SharedRoom::SharedRoom(const GroupKey& key, Scene scene, const Vec3& place, const SharedRoom* other)
    : key_(key),
      scene_(std::move(scene)),
      entry_(std::make_shared<Entry>()),
      length_(other != nullptr ? other->length_ : std::make_shared<GrowingLength>()),
      measured_(length_->hear()),
      room_length_s_(other != nullptr ? other->room_length_s_ : std::nullopt),
      waves_(scene_, WavesReady::later),
      place_(place),
      load_([this](int rays, int wanted) {
          reported_rays_ = rays;
          reported_wanted_ = wanted;
          for (const GroupVoice* const voice : voices_) voice->report_rays(rays, wanted);
      }) {
    entry_->place = place;
    for (const Object& object : scene_.objects) objects_.push_back(object.transform_at(0));
    // Built on the propagation thread, whose scheduling and rounding the threads of the propagation
    // inherit.
    std::promise<void> built;
    thread_ = std::thread([this, &built] {
        try {
            build();
        } catch (...) {
            return built.set_exception(std::current_exception());
        }
        built.set_value();
        run();
    });
    try {
        built.get_future().get();
    } catch (...) {
        thread_.join();
        throw;
    }
}

SharedRoom::~SharedRoom() {
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
    }
    changed_.notify_all();
    thread_.join();
}

/// The propagation of the scene with one source, which is removed: the first instance adds its own.
void SharedRoom::build() {
    leave_realtime();
    std::fesetenv(FE_DFL_ENV);
    lower_priority(kPropagationNice);
    Scene scene = scene_;
    scene.simulation.threads.reset();
    if (!room_length_s_) room_length_s_ = room_length_s(scene);
    length_->fit(scene, room_length_s_);
    propagation_.emplace(scene, scene.simulation);
    propagation_->remove_source(0);
    propagation_->emit_from_listeners();
    rays_ = scene.simulation.ray_count();
}

void SharedRoom::add(GroupVoice& voice) {
    Turn turn(*this);
    if (failure_) std::rethrow_exception(failure_);
    voice.read_controls();
    for (std::size_t s = 0; s < voice.sources(); ++s)
        propagation_->add_source(voice.source(s), scene_.sources[0].directivity);
    voices_.push_back(&voice);
    if (reported_rays_ < reported_wanted_) voice.report_rays(reported_rays_, reported_wanted_);
    turn.end();
    heard_.wait_for(turn.lock(), kLongestWait, [&] { return voice.is_heard() || failure_; });
    if (!failure_) return;
    std::erase(voices_, &voice);
    std::rethrow_exception(failure_);
}

void SharedRoom::remove(GroupVoice& voice) {
    const Turn turn(*this);
    const auto at = std::find(voices_.begin(), voices_.end(), &voice);
    std::size_t first = 0;
    for (auto other = voices_.begin(); other != at; ++other) first += (*other)->sources();
    for (std::size_t s = 0; s < voice.sources() && !failure_; ++s)
        propagation_->remove_source(first);
    voices_.erase(at);
}

/// False at the end.
bool SharedRoom::wait_until(FrameClock::Clock::time_point time) {
    std::unique_lock lock(mutex_);
    return !changed_.wait_until(lock, time, [this] { return stop_; });
}

void SharedRoom::run() {
    FrameClock clock(FrameClock::Clock::now());
    try {
        run_frames(clock, 1 / double{scene_.simulation.frame_rate_hz}, *this);
    } catch (...) {
        {
            const std::lock_guard lock(entry_->mutex);
            entry_->open = false;
        }
        const std::lock_guard lock(mutex_);
        failure_ = std::current_exception();
    }
    heard_.notify_all();
}

bool SharedRoom::publish_frame(FrameClock& /*clock*/) {
    const std::lock_guard lock(mutex_);
    for (GroupVoice* const voice : voices_) voice->publish();
    heard_.notify_all();
    return true;
}

double SharedRoom::compute_frame(FrameClock& clock) {
    const auto begin = FrameClock::Clock::now();
    const bool computed = compute(clock.time_s());
    took_s_ = std::chrono::duration<double>(FrameClock::Clock::now() - begin).count();
    if (computed && length_->add(took_s_, 1 / double{scene_.simulation.frame_rate_hz})) make_way();
    return took_s_;
}

/// Has all instances leave for a room whose responses have another length.
void SharedRoom::make_way() {
    {
        const std::lock_guard lock(entry_->mutex);
        entry_->open = false;
    }
    const std::lock_guard lock(mutex_);
    makes_way_ = true;
}

/// False if there is nothing to compute.
bool SharedRoom::compute(double time_s) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return waiting_ == 0 || stop_; });
    if (voices_.empty() || stop_) return false;
    int rays = 1;
    FrameInput input;
    for (GroupVoice* const voice : voices_) {
        voice->begin_frame(time_s);
        for (std::size_t s = 0; s < voice->sources(); ++s) {
            const Pose source = voice->source(s);
            input.sources.push_back(source.position);
            input.source_rotations.push_back(source.rotation());
        }
        rays = std::max(rays, voice->rays());
    }
    rays = load_.next(rays, took_s_, 1 / double{scene_.simulation.frame_rate_hz});
    if (rays != rays_) propagation_->set_rays(rays);
    rays_ = rays;
    choose_place();
    input.listeners.push_back(place_);
    input.objects = objects_;
    waves_.begin_frame(time_s, input.sources, objects_);
    propagation_->step(input);
    std::size_t source = 0;
    for (GroupVoice* const voice : voices_) {
        std::array<GroupVoice::Arriving, kMostSources> arriving;
        for (std::size_t s = 0; s < voice->sources(); ++s, ++source) {
            const EnergyResponse& response = propagation_->response(source);
            arriving[s] = {&response, waves_.pair(input.sources[source], place_, response)};
        }
        voice->prepare(std::span(arriving).first(voice->sources()));
    }
    return true;
}

/// The place of most listeners; of equally many, that of the oldest instance. An instance that is
/// elsewhere for some frames leaves the room, and all leave if the group has an older room for the
/// place.
void SharedRoom::choose_place() {
    std::size_t most = 0;
    Vec3 place = place_;
    for (const GroupVoice* const voice : voices_) {
        const Vec3 wanted = voice->listener();
        const auto same = static_cast<std::size_t>(
            std::count_if(voices_.begin(), voices_.end(),
                          [&](const GroupVoice* other) { return other->listener() == wanted; }));
        if (same <= most) continue;
        most = same;
        place = wanted;
    }
    const auto now = FrameClock::Clock::now();
    still_frames_ = place == place_ ? still_frames_ + 1 : 0;
    if (still_frames_ == 0) moved_ = now;
    place_ = place;
    {
        const std::lock_guard lock(entry_->mutex);
        entry_->place = place_;
    }
    const bool moves = still_frames_ < kFramesElsewhere;
    const bool merges = now - moved_ >= kStill && has_older_twin();
    for (GroupVoice* const voice : voices_) {
        const float distance_m = glm::distance(voice->listener(), place_);
        const bool elsewhere = moves ? distance_m > kSamePlace_m : distance_m > 0;
        voice->frames_elsewhere = elsewhere ? voice->frames_elsewhere + 1 : 0;
        if (merges || makes_way_ || voice->frames_elsewhere >= kFramesElsewhere) voice->leave();
    }
}

/// Whether the group has an older room for the same place.
bool SharedRoom::has_older_twin() const {
    Register& present = all();
    // It is locked while a room is built.
    const std::unique_lock lock(present.mutex, std::try_to_lock);
    if (!lock) return false;
    const auto rooms = present.rooms.find(key_);
    if (rooms == present.rooms.end()) return false;
    return std::any_of(rooms->second.begin(), rooms->second.end(), [&](const auto& weak) {
        const std::shared_ptr<Entry> other = weak.lock();
        if (!other || other == entry_) return false;
        const std::lock_guard lock_other(other->mutex);
        return other->open && other->number < entry_->number && other->place == place_;
    });
}

}  // namespace aula::plugin
