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

/// Listens for OSC messages on a UDP port and does what they say, on a thread of its own: poses,
/// positions and gains at once, for the next frame; materials are left to who owns the scene. What
/// is malformed or unknown is ignored. The messages stand in docs/app.md.
class OscRemote {
 public:
    /// `address`: a port on this machine alone ("9000"), or ADDRESS:PORT. The player outlives it.
    /// Throws Error if that is no address or is taken.
    OscRemote(const std::string& address, Player& player, std::vector<std::string> source_names);
    ~OscRemote();
    OscRemote(const OscRemote&) = delete;
    OscRemote& operator=(const OscRemote&) = delete;

    /// Other sources from now on.
    void set_sources(std::vector<std::string> names);

    /// Materials to be replaced everywhere since the last call: what was, what is to be; each
    /// material once, and not more than 64.
    std::vector<std::pair<std::string, std::string>> take_materials();

    int port() const { return input_.port(); }

 private:
    void run();
    void obey(const OscMessage& message);
    void obey_listener(const OscMessage& message);
    void obey_source(const OscMessage& message);

    Player& player_;
    std::mutex mutex_;  ///< of the names and the materials
    std::vector<std::string> names_;
    std::vector<std::pair<std::string, std::string>> materials_;
    std::atomic<bool> stop_ = false;
    OscInput input_;
    std::thread thread_;  ///< started last
};

}  // namespace aula
