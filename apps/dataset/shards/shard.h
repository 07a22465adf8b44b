#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/dataset/base/tar.h"
#include "apps/dataset/plan/plan.h"
#include "apps/dataset/shards/item.h"

namespace aula {

/// What a shard contains.
struct ShardContents {
    std::uint64_t responses = 0;
    std::uint64_t errors = 0;  ///< items without a response
};

/// The members of an item in a shard.
struct ItemMembers {
    std::uint64_t index = 0;
    TarMember json;
    std::optional<TarMember> wav;  ///< absent: the item has an error
};

/// Calls `visit` for each item of a complete shard, in their order. Throws InputError if the file
/// is missing or damaged, or belongs to another plan.
void visit_items(const Plan& plan, std::size_t shard,
                 const std::function<void(const TarReader&, const ItemMembers&)>& visit);

/// Reads an item of a shard. Throws InputError if its bytes are not those that were written.
Item read_intact_item(const TarReader& tar, const ItemMembers& members);

/// Why an item of a shard has no response. Throws InputError.
std::string item_error(const TarReader& tar, const ItemMembers& item);

/// The contents of a shard; empty unless it is complete and belongs to the plan.
std::optional<ShardContents> find_shard(const Plan& plan, std::size_t shard);

/// Computes a shard and writes it under its name when it is complete, `threads` scenes at a time.
/// Its bytes depend on the plan only. `report` receives the number of finished items. Returns empty
/// when `continues` [any thread] returns false; nothing is left then. Throws Failure if writing
/// fails.
std::optional<ShardContents> compute_shard(const Plan& plan, std::size_t shard, int threads,
                                           const std::function<bool()>& continues,
                                           const std::function<void(std::uint64_t)>& report);

}  // namespace aula
