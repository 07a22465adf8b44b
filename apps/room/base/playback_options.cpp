#include "apps/room/base/playback_options.h"

#include "audio/file/headphone_file.h"
#include "audio/spatial/hrtf.h"

namespace aula {

std::shared_ptr<const Hrtf> hrtf_for(const PlaybackOptions& options, double sample_rate_hz) {
    if (options.output != OutputFormat::binaural) return nullptr;
    return load_hrtf(options.hrtf, sample_rate_hz);
}

std::shared_ptr<const HeadphoneFilter> headphones_for(const PlaybackOptions& options,
                                                      double sample_rate_hz) {
    if (options.headphones.empty()) return nullptr;
    return read_headphones(options.headphones, sample_rate_hz);
}

}  // namespace aula
