#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "apps/plugin/control_snapshot.h"
#include "apps/plugin/loader_thread.h"
#include "apps/plugin/message_queue.h"
#include "apps/plugin/plugin_room.h"
#include "apps/room/base/room_exchange.h"
#include "audio/base/mailbox.h"

namespace aula::plugin {

/// Builds and destroys the rooms of an instance on the loader thread of the process, because both
/// take long and the threads of a host may have real-time priority. If a file cannot be read, it
/// builds the default room or uses the default HRTF, keeps the file's name, and reports the error.
class RoomLoader {
 public:
    explicit RoomLoader(const PluginPorts& ports);
    ~RoomLoader();
    RoomLoader(const RoomLoader&) = delete;
    RoomLoader& operator=(const RoomLoader&) = delete;

    /// Builds a room on the real-time clock and waits until it is heard. [not the audio thread]
    void open();
    /// Builds a room on the real-time clock later. [audio thread, wait-free]
    void request_open() noexcept AULA_NONBLOCKING;
    /// Builds another room later, if one is open. [any thread, wait-free]
    void request_another() noexcept AULA_NONBLOCKING;
    /// Destroys it; a room that the audio thread holds has been given back. [not the audio thread]
    void close();

    /// The present files, also those that cannot be read.
    RoomFiles files() const;
    /// Replaces the files. Waits until the room is built, if one is open. [not the audio thread]
    void set_files(const RoomFiles& files);
    /// Replaces the files; the room is built later, if one is open. [not the audio thread]
    void change_files(const RoomFiles& files);

    /// The line of the property status. [not the audio thread]
    std::string status() const;

    /// Asks for another file; false if there were too many requests. The replies of replies()
    /// confirm it. [audio thread, wait-free]
    bool request(Property property, std::string_view file) noexcept AULA_NONBLOCKING;
    /// Changes and errors for the host. [reader: audio thread, wait-free]
    MessageQueue& replies() noexcept AULA_NONBLOCKING { return replies_; }
    /// Sends all properties to replies(). [audio thread, wait-free]
    void request_replies() noexcept AULA_NONBLOCKING;

    /// Counts samples of the input that were muted; the status has their number. [audio thread,
    /// wait-free]
    void count_muted(std::size_t samples) noexcept AULA_NONBLOCKING;

    /// The status has the rays of the room in real time while they are fewer than `wanted`. [any
    /// thread, wait-free]
    void report_rays(int rays, int wanted) noexcept;

    /// A new room on the real-time clock, or null. [audio thread, wait-free]
    PluginRoom* take() noexcept AULA_NONBLOCKING { return rooms_.take(); }
    void give_back(PluginRoom* room) noexcept AULA_NONBLOCKING;

    /// A new room on the exact clock, after all earlier requests; null if none can be built. Waits.
    std::unique_ptr<OwnRoom> exact_room();
    /// Destroys a room on the exact clock later; null: none. [audio thread, lock-free]
    void discard(OwnRoom* room) noexcept AULA_NONBLOCKING;

    /// The controls of the rooms on the real-time clock. [audio thread]
    ControlSnapshot& controls() noexcept AULA_NONBLOCKING { return *controls_; }

 private:
    void serve();
    void destroy_discarded();
    void handle_requests();
    void build_live();
    void build_exact();
    template <typename Room>
    std::unique_ptr<Room> build(
        const std::function<std::unique_ptr<Room>(const RoomFiles& readable)>& make);
    PluginPorts ports_with(const RoomFiles& readable) const;
    std::unique_ptr<PluginRoom> live_room(const RoomFiles& readable);
    void set_status(const std::string& line);
    void reply_all();
    void change_and_wait(const std::function<void()>& change);

    const PluginPorts ports_;
    const std::shared_ptr<ControlSnapshot> controls_ = std::make_shared<ControlSnapshot>();
    const std::shared_ptr<GrowingLength> length_ = std::make_shared<GrowingLength>();

    MessageQueue requests_;
    MessageQueue replies_;
    std::atomic<bool> wants_replies_ = false;
    std::atomic<bool> wants_open_ = false;
    std::atomic<bool> wants_another_ = false;
    std::atomic<std::int64_t> muted_samples_ = 0;
    std::atomic<int> rays_ = 0;
    std::atomic<int> wanted_rays_ = 0;
    std::atomic<OwnRoom*> discarded_ = nullptr;  ///< the newest one of a list
    Mailbox<PluginRoom> rooms_{RoomExchange<PluginRoom, RoomLoader>::kMaxHeld};

    mutable std::mutex mutex_;  ///< of what follows
    std::condition_variable done_;
    RoomFiles files_;
    bool open_ = false;
    std::uint64_t wanted_ = 0;  ///< counts the changes of what is to be built in real time
    std::uint64_t built_ = 0;   ///< of them, those in the newest room
    bool wants_exact_ = false;
    std::unique_ptr<OwnRoom> exact_;
    std::string status_;

    LoaderTask task_;
};

}  // namespace aula::plugin
