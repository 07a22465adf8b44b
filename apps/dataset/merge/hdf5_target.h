#pragma once

#include <memory>

#include "apps/dataset/merge/merge_target.h"
#include "apps/dataset/merge/merged_folder.h"
#include "apps/dataset/plan/plan.h"

namespace aula {

/// Writes responses.h5: a row for each item with a response, padded with zeros to the longest.
/// Keeps references.
std::unique_ptr<MergeTarget> make_hdf5_target(const Plan& plan, const MergeSizes& sizes,
                                              MergedFolder& folder);

}  // namespace aula
