#include "apps/window/model/playback_messages.h"

#include "apps/output/formatted.h"

namespace aula {

bool PlaybackMessages::take(const PlayStatus& status, const MonitorStatus& monitor, double now_s,
                            MessageLog& log) {
    const bool muted = status.muted_samples > 0;
    if (muted && !muted_) log.say("samples that are not finite, or beyond 1e6, are muted", true);
    muted_ = muted;

    const std::string silent = silent_text(status.silent_pairs, status.sources.size());
    if (silent != silent_) {
        const bool is_first = silent_.empty() && status.silent_pairs == 0;
        log.remove_errors("reaches the listener");
        if (!is_first) log.say(silent, status.silent_pairs > 0);
        silent_ = silent;
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
