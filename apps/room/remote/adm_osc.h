#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/room/frames/play_controls.h"
#include "apps/room/remote/osc.h"
#include "apps/room/remote/osc_options.h"

namespace aula {

/// True if an OSC 1.0 address pattern without slash (*, ?, [a-z], [!a-z], {one,two}) matches a
/// text. False for patterns that would take many steps.
bool matches(std::string_view pattern, std::string_view text);

/// Poses in the newest frame.
struct PresentPoses {
    Pose listener;
    std::vector<Vec3> sources;  ///< of a scene's sources; may be fewer
};

/// Messages of ADM-OSC 1.0 (https://immersive-audio-live.github.io/ADM-OSC/): object N is the Nth
/// source of the scene, from 1 on. Coordinates are relative to an AdmRegion: x to the right, y to
/// the front, z up, -1 to 1; azimuth to the left and elevation up in degrees, distance 0 to 1.
/// Values out of range are clamped. Messages that are not known are ignored.
class AdmOsc {
 public:
    AdmOsc(const Scene& scene, const AdmRegion& region);

    /// Applies a message to the controls. Returns the answers to a query: a message without
    /// arguments.
    std::vector<OscAnswer> handle(const OscMessage& message, PlayControls& controls,
                                  const PresentPoses& present);

    const AdmRegion& region() const { return region_; }

 private:
    /// A source as an object of ADM-OSC.
    struct AdmObject {
        float gain_db = 0;       ///< of the scene
        std::string name;        ///< the source's, until a message changes it
        float radius_m = 1;      ///< distance of the coordinate 1
        double azimuth_deg = 0;  ///< newest ones, for positions that have none
        double elevation_deg = 0;
    };

    std::vector<OscAnswer> handle_listener(const OscMessage& message, PlayControls& controls,
                                           const PresentPoses& present) const;
    void change(std::size_t object, std::string_view parameter, const OscMessage& message,
                SourceControl& control, const Vec3& position);
    std::optional<OscAnswer> answer(std::size_t object, const std::string& address,
                                    std::string_view parameter, const SourceControl& control,
                                    const Vec3& position) const;

    AdmRegion region_;
    std::vector<AdmObject> objects_;
    std::vector<Vec3> initial_positions_;
};

}  // namespace aula
