#include "apps/room/live/reduction_reporter.h"

#include "apps/output/formatted.h"

namespace aula {

namespace {

constexpr double kShorter_s = 0.01;  // tolerance for the rounding to bins

bool fewer_rays(const PlayStatus& s) { return s.rays < s.full_rays; }
bool shorter(const PlayStatus& s) {
    return s.response_length_s < s.full_response_length_s - kShorter_s;
}

/// What is reduced, and its unreduced value.
std::string reduced_text(const PlayStatus& s) {
    std::string text;
    if (fewer_rays(s)) text += formatted("%d of %d rays", s.rays, s.full_rays);
    if (fewer_rays(s) && shorter(s)) text += " and ";
    if (shorter(s))
        text +=
            formatted("%.1f of %.1f s of response", s.response_length_s, s.full_response_length_s);
    return text;
}

}  // namespace

std::string reduction_text(const PlayStatus& s) {
    const std::string text = reduced_text(s);
    return text.empty() ? "" : "keeps up with " + text;
}

void ReductionReporter::count_from(const PlayStatus& s, double now_s) {
    counted_since_s_ = now_s;
    frames_ = s.frames;
    late_ = s.late_frames;
}

std::optional<std::string> ReductionReporter::take(const PlayStatus& s, double now_s) {
    // A response with room to grow becomes longer within this time (LiveLoad).
    constexpr double kStableTime_s = 6;
    const std::string reduced = reduced_text(s);
    const bool falls = length_s_ && s.response_length_s < *length_s_ - kShorter_s;
    const bool grows = length_s_ && s.response_length_s > *length_s_ + kShorter_s;
    reported_ = reported_ && !falls;
    if (!length_s_ || falls || grows || reduced_ == reduced.empty()) {
        length_s_ = s.response_length_s;
        reduced_ = !reduced.empty();
        since_s_ = now_s;
        count_from(s, now_s);
    }
    // Preparation slows down the frames.
    if (s.preparing) count_from(s, now_s);
    if (s.preparing || now_s < since_s_ + kStableTime_s) return std::nullopt;
    const auto frames = s.frames - frames_;
    const bool late = 2 * (s.late_frames - late_) > frames;
    const double time_s = now_s - counted_since_s_;
    since_s_ = now_s;
    count_from(s, now_s);
    if (reported_ || (!late && !reduced_)) return std::nullopt;
    reported_ = true;
    if (!late) return reduction_text(s) + "; " + remedy_;
    return formatted("computes %.1f of %.0f frames per second",
                     static_cast<double>(frames) / time_s, 1000 / s.frame_period_ms) +
           (reduced_ ? " with " + reduced : "") +
           "; fewer sources or rays, shorter responses or fewer frames per second take less time";
}

}  // namespace aula
