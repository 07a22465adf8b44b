#pragma once

#include <future>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "apps/room/waves/wave_join.h"
#include "aula/engine/energy_response.h"
#include "aula/engine/scene.h"

namespace aula {

/// When the modes of a room are ready.
enum class WavesReady {
    at_once,  ///< before the frame that needs them: the same sound in each run
    later     ///< a thread finds them, and rays are alone until then
};

/// The modes of the rooms of a scene's sources while it is played. They follow objects that move,
/// materials that change and sources that come to another room. [propagation thread]
class FrameWaves {
 public:
    /// None with Simulation::waves_hz of 0.
    FrameWaves(const Scene& scene, WavesReady ready);
    /// Ends a search for modes, in some tenths of a second.
    ~FrameWaves() { stop_.request_stop(); }

    // See Propagation.
    void set_object_material(std::size_t object, const Material& material);
    void change_material(std::size_t material, const Material& coefficients);

    /// The frame at a time, with the places of all sources and one transform per object, or,
    /// without any, the objects on their paths: takes modes that are ready, and begins to find
    /// those of rooms that have changed.
    void begin_frame(double time_s, std::span<const Vec3> sources,
                     std::span<const RigidTransform> objects);

    /// The field of a pair whose rays have a response; empty if rays are alone.
    std::optional<PairWaves> pair(const Vec3& source, const Vec3& receiver,
                                  const EnergyResponse& rays) const;

 private:
    bool is_known(const Vec3& source) const;
    void find();

    std::optional<Scene> scene_;  ///< with all changes of materials; empty: rays alone
    WavesReady ready_;
    std::map<std::size_t, std::uint32_t> own_materials_;  ///< [object] whose material has changed
    std::vector<RigidTransform> objects_;                 ///< in the newest frame
    std::vector<Vec3> places_;  ///< of the sources when the last search for modes began
    bool is_old_ = true;        ///< something has changed since then
    double found_s_ = 0;        ///< time of the frame in which it began
    std::shared_ptr<const WaveJoin> join_;
    std::stop_source stop_;  ///< of the search
    std::future<std::shared_ptr<const WaveJoin>> search_;
};

}  // namespace aula
