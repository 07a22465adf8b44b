#include "apps/unity/room_player.h"

#include <chrono>
#include <cstring>
#include <system_error>
#include <utility>

#include "apps/unity/axes.h"

namespace aula::unity {
namespace {

using std::chrono::milliseconds;

/// The time between two looks at the poses: a third of a propagation frame at 30 Hz.
constexpr milliseconds kPeriod{10};

constexpr const char* kDirectivities[] = {
    "omni", "subcardioid", "cardioid", "supercardioid", "figure_of_eight", "talker", "loudspeaker"};

bool equal(const aula_pose& a, const aula_pose& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

}  // namespace

RoomPlayer& RoomPlayer::get() {
    static RoomPlayer& player = *new RoomPlayer;
    return player;
}

void RoomPlayer::play(aula_room* room) {
    const std::lock_guard lock(play_mutex_);
    stop_moving();
    room_ = nullptr;
    while (renders_) std::this_thread::sleep_for(milliseconds(1));
    for (std::size_t i = 0; i < slot_count_; ++i) slots_[i]->number = 0;
    head_ = {};
    last_problem_.clear();
    if (room == nullptr) return;
    try {
        mover_ = std::thread([this, room] { move(room); });
        room_ = room;
    } catch (const std::system_error&) {
        const std::lock_guard locked(mutex_);
        problem_ = "no thread can be started that moves the sources";
    }
}

SourceSlot* RoomPlayer::take_slot() {
    const std::lock_guard lock(mutex_);
    std::size_t i = 0;
    // A slot is free when the room has no source of it any more.
    while (i < slot_count_ && (slots_[i]->is_used || slots_[i]->number != 0)) ++i;
    if (i == kMostSources) return nullptr;
    if (i == slot_count_) {
        slots_[i] = std::make_unique<SourceSlot>();
        ++slot_count_;
    }
    SourceSlot& slot = *slots_[i];
    slot.matrix.clear();
    slot.gain_db = 0;
    slot.directivity = 0;
    slot.is_used = true;
    return &slot;
}

bool RoomPlayer::claims(const void* effect) noexcept {
    const void* none = nullptr;
    return effect_.compare_exchange_strong(none, effect) || none == effect;
}

void RoomPlayer::resign(const void* effect) noexcept {
    effect_.compare_exchange_strong(effect, nullptr);
}

bool RoomPlayer::render(float* left, float* right, int samples) noexcept {
    renders_ = true;
    aula_room* const room = room_;
    std::size_t count = 0;
    for (std::size_t i = 0; i < slot_count_; ++i) {
        const aula_signal signal = slots_[i]->take(samples);
        if (signal.source != 0) signals_[count++] = signal;
    }
    float* const outputs[] = {left, right};
    const bool rendered = room != nullptr && aula_room_process(room, signals_.data(), count,
                                                               outputs, 2, samples) == AULA_OK;
    renders_ = false;
    return rendered;
}

std::string RoomPlayer::take_problem() {
    const std::lock_guard lock(mutex_);
    return std::exchange(problem_, {});
}

void RoomPlayer::stop_moving() {
    if (!mover_.joinable()) return;
    {
        const std::lock_guard lock(mutex_);
        stops_ = true;
    }
    stopping_.notify_all();
    mover_.join();
    stops_ = false;
}

void RoomPlayer::move(aula_room* room) {
    std::unique_lock lock(mutex_);
    while (!stops_) {
        move_listener(room);
        for (std::size_t i = 0; i < slot_count_; ++i) move_source(room, *slots_[i]);
        stopping_.wait_for(lock, kPeriod, [this] { return stops_; });
    }
}

void RoomPlayer::move_listener(aula_room* room) {
    float matrix[16];
    if (!listener.load(matrix)) return;
    const aula_pose pose = pose_from_world(matrix);
    if (equal(pose, head_)) return;
    head_ = pose;
    check(aula_room_set_listener(room, 0, &pose, AULA_NOW));
}

void RoomPlayer::move_source(aula_room* room, SourceSlot& slot) {
    const aula_source number = slot.number;
    const int directivity = slot.directivity;
    if (number != 0 && (!slot.is_used || directivity != slot.told_directivity)) {
        slot.number = 0;
        return check(aula_room_remove_source(room, number, AULA_NOW));
    }
    float matrix[16];
    if (!slot.is_used || !slot.matrix.load(matrix)) return;
    const aula_pose pose = pose_to_world(matrix);
    const float gain_db = slot.gain_db;
    if (number == 0) {
        aula_source added = 0;
        const int result =
            aula_room_add_source(room, &pose, kDirectivities[directivity], AULA_NOW, &added);
        if (result != AULA_OK) return check(result);
        check(aula_room_set_gain(room, added, gain_db, AULA_NOW));
        slot.number = added;
    } else {
        if (!equal(pose, slot.pose)) check(aula_room_set_source(room, number, &pose, AULA_NOW));
        if (gain_db != slot.told_gain_db)
            check(aula_room_set_gain(room, number, gain_db, AULA_NOW));
    }
    slot.pose = pose;
    slot.told_gain_db = gain_db;
    slot.told_directivity = directivity;
}

// An error that lasts is not repeated.
void RoomPlayer::check(int result) {
    if (result == AULA_OK || last_problem_ == aula_message()) return;
    problem_ = last_problem_ = aula_message();
}

}  // namespace aula::unity
