#pragma once

#include <cstdint>
#include <string>

#include "apps/dataset/plan/plan.h"
#include "apps/dataset/plan/planned_scene.h"

namespace aula {

// The descriptions of items (docs/datasets.md), which one program writes and others read.

/// The members of an item that its plan determines: first those of all items, then those of an item
/// with a response.
JsonValue::Object item_members(const Plan& plan, const PlannedScene& planned, std::uint64_t item);
JsonValue::Object response_members(const Plan& plan, const PlannedScene& planned,
                                   std::uint64_t item);

/// The line of an item's description with its last member, "item_sha256": the hash of the other
/// members' text and of the response.
std::string sealed_json(JsonValue::Object members, const std::string& wav);

/// True if a description and a response are those that sealed_json() hashed.
bool is_intact(const std::string& json, const std::string& wav);

}  // namespace aula
