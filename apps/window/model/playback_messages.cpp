#include "apps/window/model/playback_messages.h"

#include "apps/output/formatted.h"

namespace aula {

bool PlaybackMessages::take(const PlayStatus& status, const MonitorStatus& monitor, double now_s,
                            MessageLog& log) {
    const bool muted = status.muted_samples > 0;
    if (muted && !muted_) log.say("samples that are not finite, or beyond 1e6, are muted", true);
    muted_ = muted;

    if (status.silent_pairs != silent_pairs_) {
        silent_pairs_ = status.silent_pairs;
        log.remove_errors("reaches the listener");
        log.say(silent_text(silent_pairs_, status.sources.size()), silent_pairs_ > 0);
    }

    if (status.underruns > underruns_) last_underrun_s_ = status.time_s;
    underruns_ = status.underruns;

    const bool failed = status.failed_changes > failed_changes_;
    failed_changes_ = status.failed_changes;
    if (failed) log.say(status.change_error, true);

    if (const auto text = reductions_.take(status, now_s)) log.say("this machine " + *text);

    if (monitor.error != recording_error_) {
        recording_error_ = monitor.error;
        if (!recording_error_.empty()) log.say(recording_error_, true);
    }
    return failed;
}

}  // namespace aula
