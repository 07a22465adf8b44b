#include "apps/room/live/play_summary.h"

#include "apps/output/formatted.h"

namespace aula {

std::string play_summary(const PlayStatus& s) {
    return formatted("played %.1f s, underruns %llu, frames %llu (%llu late, %llu skipped), ",
                     s.time_s, static_cast<unsigned long long>(s.underruns),
                     static_cast<unsigned long long>(s.frames),
                     static_cast<unsigned long long>(s.late_frames),
                     static_cast<unsigned long long>(s.skipped_frames)) +
           formatted("frame mean %.1f ms worst %.1f ms, audio load mean %.1f %% worst %.0f %%",
                     s.frame_mean_ms, s.frame_worst_ms, 100 * s.mean_load, 100 * s.worst_load);
}

std::string latency_summary(const PoseLatency& l) {
    const auto ms = [](PoseLatency::Quantile_ms x) {
        return x ? formatted("%.1f ms", *x) : std::string("-");
    };
    return "pose to sound p50 " + ms(l.sound_p50_ms) + " p99 " + ms(l.sound_p99_ms) +
           formatted(" (frame period %.1f ms, ", l.frame_period_ms) + "compute p50 " +
           ms(l.compute_p50_ms) + " p99 " + ms(l.compute_p99_ms) + "), head rotation p50 " +
           ms(l.head_p50_ms) + " p99 " + ms(l.head_p99_ms) + ", callback interval p99 " +
           ms(l.call_p99_ms);
}

}  // namespace aula
