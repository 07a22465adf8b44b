#pragma once

#include <memory>

#include "apps/dataset/merge/merge_target.h"
#include "apps/dataset/merge/merged_folder.h"
#include "apps/dataset/plan/plan.h"

namespace aula {

/// Writes a SOFA file for each scene with a response: SingleRoomSRIR (AES69), netCDF-4. Its
/// measurements are the items, its receivers the channels. Keeps references. Throws InputError for
/// ambisonic responses of more than one microphone, which have no SOFA receivers.
std::unique_ptr<MergeTarget> make_sofa_target(const Plan& plan, MergedFolder& folder);

}  // namespace aula
