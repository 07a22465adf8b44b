#include "apps/session/base/session_options.h"

#include "audio/spatial/hrtf.h"

namespace aula {

std::shared_ptr<const Hrtf> hrtf_for(const SessionOptions& options, double sample_rate_hz) {
    if (options.output != OutputFormat::binaural) return nullptr;
    return load_hrtf(options.hrtf, sample_rate_hz);
}

}  // namespace aula
