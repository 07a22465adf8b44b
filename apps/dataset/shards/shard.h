#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "apps/dataset/plan/plan.h"
#include "apps/dataset/shards/shard_reader.h"

namespace aula {

/// Computes a shard and writes it under its name when it is complete, `threads` scenes at a time.
/// Its bytes depend on the plan only. `report` receives the number of finished items. Returns empty
/// when `continues` [any thread] returns false; nothing is left then. Throws Failure if writing
/// fails.
std::optional<ShardContents> compute_shard(const Plan& plan, std::size_t shard, int threads,
                                           const std::function<bool()>& continues,
                                           const std::function<void(std::uint64_t)>& report);

}  // namespace aula
