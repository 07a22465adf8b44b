#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "apps/dataset/plan/plan.h"

namespace aula {

/// Which shards of a dataset are complete.
struct DatasetStatus {
    std::vector<std::size_t> missing;   ///< shards, ascending
    std::uint64_t responses = 0;        ///< in complete shards
    std::vector<std::string> failures;  ///< "item 7: REASON" of items without a response
};

/// Reads all shards of a plan. Throws InputError for the plan. Stops early when `continues` returns
/// false.
DatasetStatus dataset_status(const Plan& plan, const std::function<bool()>& continues);

/// Numbers as a Slurm array takes them: "3,17-19"; empty if there are none.
std::string array_text(const std::vector<std::size_t>& numbers);

}  // namespace aula
