#pragma once

#include <filesystem>
#include <memory>

#include "audio/render/headphones.h"

namespace aula {

/// Reads the impulse response of a sound file: one channel for both ears, or left and right. Its
/// levels are kept at any sample rate: the gain at a frequency is that of the file. Sample 0 of
/// the file is time 0; a file of another rate that begins abruptly is later, by at most 88 samples
/// of the lower rate, as the resampler has linear phase. Zeros at the end are left out. Throws
/// InputError if the file cannot be read or is cut off, for more than two channels, silence, a
/// response longer than HeadphoneFilter::kLongest_s, and samples that are not finite or exceed 1e6.
/// Failure if the process that reads the file cannot be started.
std::shared_ptr<const HeadphoneFilter> read_headphones(const std::filesystem::path& file,
                                                       double sample_rate_hz);

}  // namespace aula
