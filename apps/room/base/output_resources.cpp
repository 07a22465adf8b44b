#include "apps/room/base/output_resources.h"

#include "audio/file/headphone_file.h"
#include "aula/exception.h"

namespace aula {

void check_output(const OutputOptions& options, const std::string& who) {
    const auto require = [&](bool holds, const char* otherwise) {
        if (!holds) throw InputError(who + ": " + otherwise);
    };
    require(options.sample_rate_hz >= 8000 && options.sample_rate_hz <= 384000,
            "the sample rate is not between 8000 and 384000 Hz");
    require(options.block >= 1 && options.block <= 8192, "the block is not between 1 and 8192");
    require(options.ambisonic_order >= 1 && options.ambisonic_order <= 3,
            "the ambisonic order is not between 1 and 3");
    require(options.headphones.empty() || options.output == OutputFormat::binaural,
            "headphones are for binaural output");
}

std::shared_ptr<const Hrtf> hrtf_for(const OutputOptions& options) {
    if (options.output != OutputFormat::binaural) return nullptr;
    return load_hrtf(options.hrtf, options.sample_rate_hz);
}

std::shared_ptr<const HeadphoneFilter> headphones_for(const OutputOptions& options) {
    if (options.headphones.empty()) return nullptr;
    return read_headphones(options.headphones, options.sample_rate_hz);
}

OutputResources::OutputResources(const OutputOptions& of, const std::string& who)
    : options((check_output(of, who), of)), hrtf(hrtf_for(of)), headphones(headphones_for(of)) {}

}  // namespace aula
