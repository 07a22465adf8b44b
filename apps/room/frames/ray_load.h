#pragma once

#include <functional>
#include <optional>

#include "apps/room/frames/live_load.h"

namespace aula {

/// Called with the rays and the wanted rays once a reduction has lasted for some seconds, and with
/// the wanted rays twice when it has ended.
using ReportRays = std::function<void(int rays, int wanted)>;

/// The rays of a room on the real-time clock, reduced until its frames are computed within their
/// period, and a report of the reduction when it is stable. [propagation thread]
class RayLoad {
 public:
    explicit RayLoad(ReportRays report);

    /// The rays of the next frame, of `wanted`, after a frame that took `took_s`.
    int next(int wanted, double took_s, double period_s);

 private:
    ReportRays report_;
    std::optional<LiveLoad> load_;
    double reduced_s_ = 0;
    bool reported_ = false;
};

}  // namespace aula
