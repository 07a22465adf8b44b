#include "apps/plugin/room_loader.h"

#include <cmath>
#include <exception>
#include <utility>

#include "apps/output/formatted.h"
#include "apps/output/printable.h"
#include "apps/plugin/group_voice.h"
#include "apps/plugin/presets.h"
#include "apps/plugin/shared_room.h"
#include "process/files.h"

namespace aula::plugin {

RoomLoader::RoomLoader(const PluginPorts& ports) : ports_(ports), task_([this] { serve(); }) {}

RoomLoader::~RoomLoader() {
    task_.stop();
    // Rooms of a group use this object until their end.
    delete rooms_.take();
    while (rooms_.reclaim()) {
    }
    destroy_discarded();
}

/// Makes a change with the mutex locked, and waits until a room contains it.
void RoomLoader::change_and_wait(const std::function<void()>& change) {
    std::unique_lock lock(mutex_);
    change();
    const std::uint64_t wanted = ++wanted_;
    task_.wake();
    done_.wait(lock, [&] { return built_ >= wanted; });
}

void RoomLoader::open() {
    change_and_wait([this] { open_ = true; });
}

void RoomLoader::request_open() noexcept {
    wants_open_ = true;
    task_.wake();
}

void RoomLoader::request_another() noexcept {
    wants_another_ = true;
    task_.wake();
}

void RoomLoader::close() {
    change_and_wait([this] { open_ = false; });
}

RoomFiles RoomLoader::files() const {
    const std::lock_guard lock(mutex_);
    return files_;
}

void RoomLoader::set_files(const RoomFiles& files) {
    change_and_wait([&] { files_ = files; });
    request_replies();
}

void RoomLoader::change_files(const RoomFiles& files) {
    {
        const std::lock_guard lock(mutex_);
        files_ = files;
        ++wanted_;
    }
    request_replies();
}

bool RoomLoader::request(Property property, std::string_view file) noexcept {
    const bool sent = requests_.push(property, file);
    task_.wake();
    return sent;
}

void RoomLoader::request_replies() noexcept {
    wants_replies_ = true;
    task_.wake();
}

// Only the first ones are announced: there may be more in every block.
void RoomLoader::count_muted(std::size_t samples) noexcept {
    if (muted_samples_.fetch_add(static_cast<std::int64_t>(samples)) == 0) request_replies();
}

void RoomLoader::report_rays(int rays, int wanted) noexcept {
    rays_ = rays;
    wanted_rays_ = wanted;
    request_replies();
}

void RoomLoader::give_back(PluginRoom* room) noexcept {
    rooms_.give_back(room);
    task_.wake();
}

std::unique_ptr<OwnRoom> RoomLoader::exact_room() {
    std::unique_lock lock(mutex_);
    wants_exact_ = true;
    task_.wake();
    done_.wait(lock, [this] { return !wants_exact_; });
    return std::move(exact_);
}

void RoomLoader::discard(OwnRoom* room) noexcept {
    if (room == nullptr) return;
    OwnRoom* before = discarded_.load();
    do room->discarded_before = before;
    while (!discarded_.compare_exchange_weak(before, room));
    task_.wake();
}

void RoomLoader::destroy_discarded() {
    for (OwnRoom* room = discarded_.exchange(nullptr); room != nullptr;)
        delete std::exchange(room, room->discarded_before);
}

void RoomLoader::serve() {
    destroy_discarded();
    while (rooms_.reclaim()) {
    }
    handle_requests();
    std::unique_lock lock(mutex_);
    const bool builds_live = built_ != wanted_;
    const bool builds_exact = wants_exact_;
    lock.unlock();
    if (builds_exact) build_exact();
    if (builds_live) build_live();
    if (wants_replies_.exchange(false)) reply_all();
}

/// Takes what the audio thread has asked for.
void RoomLoader::handle_requests() {
    if (wants_open_.exchange(false)) {
        const std::lock_guard lock(mutex_);
        open_ = true;
        ++wanted_;
    }
    if (wants_another_.exchange(false)) {
        const std::lock_guard lock(mutex_);
        ++wanted_;
    }
    for (; const Message* message = requests_.front(); requests_.pop()) {
        const std::lock_guard lock(mutex_);
        std::filesystem::path& file =
            message->property == Property::scene ? files_.scene : files_.hrtf;
        file = utf8_path(message->view());
        ++wanted_;
        wants_replies_ = true;
    }
}

void RoomLoader::build_live() {
    std::unique_lock lock(mutex_);
    const std::uint64_t wanted = wanted_;
    const bool open = open_;
    lock.unlock();
    if (open) {
        auto room =
            build<PluginRoom>([this](const RoomFiles& readable) { return live_room(readable); });
        if (room) rooms_.publish(std::move(room));
    }
    lock.lock();
    built_ = wanted;
    lock.unlock();
    done_.notify_all();
}

void RoomLoader::build_exact() {
    auto room = build<OwnRoom>([this](const RoomFiles& readable) {
        return std::make_unique<OwnRoom>(plugin_scene(readable), ports_with(readable));
    });
    std::unique_lock lock(mutex_);
    exact_ = std::move(room);
    wants_exact_ = false;
    lock.unlock();
    done_.notify_all();
}

PluginPorts RoomLoader::ports_with(const RoomFiles& readable) const {
    PluginPorts ports = ports_;
    ports.hrtf = readable.hrtf;
    return ports;
}

/// A room on the real-time clock: its own, or that of a group.
std::unique_ptr<PluginRoom> RoomLoader::live_room(const RoomFiles& readable) {
    const ControlValues values = controls_->read();
    const ReportRays report = [this](int rays, int wanted) { report_rays(rays, wanted); };
    // What it says of the room before.
    if (rays_ < wanted_rays_) report_rays(0, 0);
    const auto group = static_cast<int>(std::lround(value_of(values, Control::room_group)));
    if (group == 0) {
        auto room =
            std::make_unique<OwnRoom>(plugin_scene(readable), ports_with(readable), controls_,
                                      report, length_, [this] { request_another(); });
        room->wait_for_frame();
        return room;
    }
    auto shared =
        SharedRoom::join({readable, group}, values, [&] { return plugin_scene(readable); });
    return std::make_unique<GroupVoice>(
        std::move(shared), ports_with(readable), controls_, [this] { request_another(); }, report);
}

/// The room of the present files, or as much of it as can be built; null if nothing can.
template <typename Room>
std::unique_ptr<Room> RoomLoader::build(
    const std::function<std::unique_ptr<Room>(const RoomFiles& readable)>& make) {
    const RoomFiles files = chosen_files(this->files(), controls_->read(), ports_.folder);
    std::string status;
    const auto attempt = [&](const RoomFiles& readable) -> std::unique_ptr<Room> {
        try {
            return make(readable);
        } catch (const std::exception& error) {
            if (status.empty()) status = printable_line(error.what());
            return nullptr;
        }
    };
    auto room = attempt(files);
    if (!room) room = attempt({.scene = files.scene, .hrtf = {}, .seed = files.seed});
    if (!room) room = attempt({.scene = {}, .hrtf = files.hrtf, .seed = files.seed});
    if (!room) room = attempt({.scene = {}, .hrtf = {}, .seed = files.seed});
    set_status(status);
    return room;
}

void RoomLoader::set_status(const std::string& line) {
    const std::lock_guard lock(mutex_);
    if (line == status_) return;
    status_ = line;
    wants_replies_ = true;
}

std::string RoomLoader::status() const {
    std::unique_lock lock(mutex_);
    std::string status = status_;
    lock.unlock();
    const auto add = [&](const std::string& text) {
        status += (status.empty() ? "" : "; ") + text;
    };
    if (const std::int64_t muted = muted_samples_; muted > 0) add(muted_text(muted));
    if (const int rays = rays_, wanted = wanted_rays_; rays < wanted)
        add(formatted("this machine keeps up with %d of %d rays", rays, wanted));
    return status;
}

void RoomLoader::reply_all() {
    const RoomFiles files = this->files();
    replies_.push(Property::scene, files.scene.string());
    replies_.push(Property::hrtf, files.hrtf.string());
    replies_.push(Property::status, status());
}

}  // namespace aula::plugin
