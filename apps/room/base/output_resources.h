#pragma once

#include <memory>
#include <string>

#include "audio/render/headphones.h"
#include "audio/spatial/hrtf.h"
#include "aula/audio/output_options.h"

namespace aula {

/// Throws InputError, whose text begins with `who`, if an option is out of range.
void check_output(const OutputOptions& options, const std::string& who);

/// The HRTF of binaural output; null for other outputs. Throws InputError.
std::shared_ptr<const Hrtf> hrtf_for(const OutputOptions& options);

/// The filter of binaural output for headphones; null if there is none. Throws InputError.
std::shared_ptr<const HeadphoneFilter> headphones_for(const OutputOptions& options);

/// The options of an output with their files, read for a later use.
struct OutputResources {
    /// Throws InputError, also as check_output().
    OutputResources(const OutputOptions& of, const std::string& who);

    OutputOptions options;
    std::shared_ptr<const Hrtf> hrtf;                   ///< null: none
    std::shared_ptr<const HeadphoneFilter> headphones;  ///< null: none
};

}  // namespace aula
