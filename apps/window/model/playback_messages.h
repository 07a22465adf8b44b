#pragma once

#include <cstdint>
#include <string>

#include "apps/room/live/monitor.h"
#include "apps/room/live/player.h"
#include "apps/room/live/reduction_reporter.h"
#include "apps/window/model/message_log.h"

namespace aula {

/// Turns changes of a player's status into messages. [one thread]
class PlaybackMessages {
 public:
    /// Compares with the status of the last call. True if a change of scene or options has failed
    /// since.
    bool take(const PlayStatus& status, const MonitorStatus& monitor, double now_s,
              MessageLog& log);

    /// Time of the sound at the last underrun; negative: none.
    double last_underrun_s() const { return last_underrun_s_; }

 private:
    std::uint64_t underruns_ = 0;
    double last_underrun_s_ = -1;
    bool muted_ = false;
    std::string silent_;  ///< the last text
    std::uint64_t failed_changes_ = 0;
    ReductionReporter reductions_{"rays and duration in Quality set them"};
    std::string recording_error_;
};

}  // namespace aula
