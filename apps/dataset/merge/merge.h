#pragma once

#include <functional>
#include <optional>
#include <string>

#include "apps/dataset/plan/plan.h"

namespace aula {

/// What the shards of a dataset are merged to.
enum class MergeFormat {
    wav,   ///< the items as files
    hdf5,  ///< one file of all responses
    sofa   ///< one file for each scene, SingleRoomSRIR of AES69
};

/// The format of the name "wav", "hdf5" or "sofa"; empty for another name.
std::optional<MergeFormat> merge_format(const std::string& name);

/// Writes all items of a complete dataset in their order to the folder "wav", "hdf5" or "sofa" of
/// the dataset, with index.csv, README.md and SHA256SUMS. The bytes depend on the plan only, not on
/// its shards. The folder gets its name when it is complete and replaces an earlier one. Returns
/// false when `continues` does; nothing is left then. Throws InputError if a shard is missing or
/// damaged, Failure if writing fails.
bool merge_dataset(const Plan& plan, MergeFormat format, const std::function<bool()>& continues);

}  // namespace aula
