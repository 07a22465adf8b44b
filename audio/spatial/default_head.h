#pragma once

#include "audio/spatial/sofa_file.h"

namespace aula {

/// The head-related impulse responses of the KEMAR manikin with normal pinnae, measured by Gardner
/// and Martin (MIT Media Lab, 1994) at 710 directions from -40 degrees elevation to the zenith.
HeadMeasurements default_head();

}  // namespace aula
