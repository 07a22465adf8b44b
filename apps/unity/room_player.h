#pragma once

#include <aula.h>

#include <array>
#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "apps/unity/source_slot.h"

namespace aula::unity {

/// Joins the effects of the process: the spatializers give it the sound and the place of their
/// sources, the effect of the mixer gets the sound of the room. A thread of its own hands the
/// newest poses to the room.
class RoomPlayer {
 public:
    /// Most sources at the same time.
    static constexpr std::size_t kMostSources = 1024;

    /// That of the process, which is never destroyed: effects may outlive static objects.
    static RoomPlayer& get();

    /// Plays a room from now on; null: none. Not owned. Returns when the room before is not used
    /// any more. [any thread but the audio thread]
    void play(aula_room* room);

    /// A slot for a spatializer; null if there are kMostSources. [any thread but the audio thread]
    SourceSlot* take_slot();
    /// [any thread, wait-free]
    void give_back(SourceSlot& slot) noexcept { slot.is_used = false; }

    /// Whether an effect of the mixer renders: only the first one does. [audio thread, wait-free]
    bool claims(const void* effect) noexcept;
    /// The effect is gone. [any thread, wait-free]
    void resign(const void* effect) noexcept;

    /// Whether a room plays and an effect of the mixer renders it. [any thread, wait-free]
    bool is_heard() const noexcept { return room_ != nullptr && effect_ != nullptr; }
    /// Renders the present block. False if no room plays. [audio thread, wait-free]
    bool render(float* left, float* right, int samples) noexcept;

    /// From the world to the listener. [audio thread: store(), wait-free]
    SharedMatrix listener;

    /// The newest problem, which is then forgotten; empty if there is none. [any thread but the
    /// audio thread]
    std::string take_problem();

 private:
    RoomPlayer() = default;

    void move(aula_room* room);
    /// Ends the thread. [with play_mutex_]
    void stop_moving();
    void move_listener(aula_room* room);
    void move_source(aula_room* room, SourceSlot& slot);
    /// Keeps the library's message if a result is an error.
    void check(int result);

    std::atomic<aula_room*> room_{nullptr};
    std::atomic<bool> renders_{false};
    std::atomic<const void*> effect_{nullptr};  ///< that renders
    std::atomic<std::size_t> slot_count_{0};
    std::array<std::unique_ptr<SourceSlot>, kMostSources> slots_;
    std::array<aula_signal, kMostSources> signals_{};

    std::mutex play_mutex_;  ///< of the thread
    std::thread mover_;
    std::mutex mutex_;  ///< of what follows, and of new slots
    std::condition_variable stopping_;
    bool stops_ = false;
    aula_pose head_{};
    std::string problem_;
    std::string last_problem_;
};

}  // namespace aula::unity
