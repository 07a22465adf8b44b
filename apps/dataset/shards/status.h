#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "apps/dataset/plan/plan.h"

namespace aula {

/// Which shards of a dataset are complete.
struct DatasetStatus {
    std::vector<std::size_t> missing;   ///< shards, ascending; also those that are damaged
    std::vector<std::string> damaged;   ///< why shards that are there do not count
    std::uint64_t responses = 0;        ///< in complete shards
    std::vector<std::string> failures;  ///< "item 7: REASON" of items without a response
};

/// Lists the items of all shards of a plan; `verifies` reads them whole. Throws InputError for the
/// plan. Stops early when `continues` returns false.
DatasetStatus dataset_status(const Plan& plan, bool verifies,
                             const std::function<bool()>& continues);

/// Numbers as a Slurm array takes them: "3,17-19"; empty if there are none.
std::string array_text(const std::vector<std::size_t>& numbers);

}  // namespace aula
