#pragma once

#include <atomic>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "apps/session/live/player.h"
#include "apps/session/remote/osc.h"

namespace aula {

/// Receives OSC messages on a UDP port on a separate thread. Poses, positions and gains are applied
/// immediately, for the next frame; changes of materials are left to the owner of the scene.
/// Malformed and unknown messages are ignored. docs/app.md lists the messages.
class OscRemote {
 public:
    /// `address`: a port on this machine alone ("9000"), or ADDRESS:PORT. The player must outlive
    /// this object. Throws InputError if the address is invalid or in use.
    OscRemote(const std::string& address, Player& player, const std::vector<Source>& sources);
    ~OscRemote();
    OscRemote(const OscRemote&) = delete;
    OscRemote& operator=(const OscRemote&) = delete;

    /// Replaces the sources, whose names the messages use.
    void set_sources(const std::vector<Source>& sources);

    /// The replacements of materials requested since the last call (old name, new name); each
    /// material once, and at most 64.
    std::vector<std::pair<std::string, std::string>> take_materials();

    int port() const { return input_.port(); }

 private:
    void run();
    void handle(const OscMessage& message);
    void handle_listener(const OscMessage& message);
    void handle_source(const OscMessage& message);

    Player& player_;
    std::mutex mutex_;  ///< protects the names and the materials
    std::vector<std::string> names_;
    std::vector<std::pair<std::string, std::string>> materials_;
    std::atomic<bool> stop_ = false;
    OscInput input_;
    std::thread thread_;  ///< started last
};

}  // namespace aula
