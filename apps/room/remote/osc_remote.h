#pragma once

#include <atomic>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "apps/room/live/player.h"
#include "apps/room/remote/adm_osc.h"
#include "apps/room/remote/osc.h"

namespace aula {

/// Receives OSC messages on a UDP port on a separate thread. Poses, positions and gains are applied
/// immediately, for the next frame; changes of materials are left to the owner of the scene.
/// Malformed and unknown messages are ignored. Messages of Aula, ADM-OSC 1.0 and head trackers
/// share the port; docs/app.md lists them. Queries of ADM-OSC are answered to port 4002 of their
/// sender.
class OscRemote {
 public:
    /// The player must outlive this object. Throws InputError if the address is invalid or in use.
    OscRemote(const OscOptions& options, Player& player, const Scene& scene);
    ~OscRemote();
    OscRemote(const OscRemote&) = delete;
    OscRemote& operator=(const OscRemote&) = delete;

    /// Replaces the scene, to whose sources the messages refer.
    void set_scene(const Scene& scene);

    /// AdmRegion::text() of the scene.
    std::string region_text() const;

    /// The replacements of materials requested since the last call (old name, new name); each
    /// material once, and at most 64.
    std::vector<std::pair<std::string, std::string>> take_materials();

    int port() const { return input_.port(); }

 private:
    void run();
    void handle(const OscMessage& message);
    void handle_listener(const OscMessage& message);
    void handle_source(const OscMessage& message);
    void handle_material(const OscMessage& message);
    void handle_adm(const OscMessage& message);
    void handle_head_tracker(const OscMessage& message);

    const OscOptions options_;
    Player& player_;
    mutable std::mutex mutex_;  ///< protects the names, the objects and the materials
    std::vector<std::string> names_;
    AdmOsc adm_;
    std::vector<std::pair<std::string, std::string>> materials_;
    std::atomic<bool> stop_ = false;
    OscInput input_;
    std::thread thread_;  ///< started last
};

}  // namespace aula
