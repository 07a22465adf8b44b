#include "apps/session/live/reduction_reporter.h"

#include "apps/session/base/formatted.h"

namespace aula {

namespace {

constexpr double kShorter_s = 0.01;  // tolerance for the rounding to bins

bool fewer_rays(const PlayStatus& s) { return s.rays < s.full_rays; }
bool shorter(const PlayStatus& s) {
    return s.response_length_s < s.full_response_length_s - kShorter_s;
}

}  // namespace

std::string reduction_text(const PlayStatus& s) {
    if (!fewer_rays(s) && !shorter(s)) return "";
    std::string text = "keeps up with ";
    if (fewer_rays(s)) text += formatted("%d of %d rays", s.rays, s.full_rays);
    if (fewer_rays(s) && shorter(s)) text += " and ";
    if (shorter(s))
        text +=
            formatted("%.1f of %.1f s of response", s.response_length_s, s.full_response_length_s);
    return text;
}

std::optional<std::string> ReductionReporter::take(const PlayStatus& s, double now_s) {
    // A response with room to grow becomes longer within this time (LiveLoad).
    constexpr double kStableTime_s = 6;
    const std::string text = reduction_text(s);
    if (text.empty()) return std::nullopt;
    const bool falls = length_s_ && s.response_length_s < *length_s_ - kShorter_s;
    if (!length_s_ || falls || s.response_length_s > *length_s_ + kShorter_s) {
        reported_ = reported_ && length_s_ && !falls;
        length_s_ = s.response_length_s;
        since_s_ = now_s;
    }
    if (reported_ || s.preparing || now_s < since_s_ + kStableTime_s) return std::nullopt;
    reported_ = true;
    return text + "; --rays and --ir-length set them";
}

}  // namespace aula
