#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/dataset/plan/plan.h"
#include "apps/dataset/plan/planned_scene.h"

namespace aula {

/// An item: a source at a receiver.
struct Item {
    std::uint64_t index = 0;
    std::string json;  ///< its description, or why it has no response under "error"
    std::string wav;   ///< the response of all microphones; empty after an error
};

/// Computes the items of a scene. Errors of input become items with an error. Returns empty if
/// `continues` returned false.
std::optional<std::vector<Item>> compute_items(const Plan& plan, const PlannedScene& planned,
                                               SceneFiles& files,
                                               const std::function<bool()>& continues);

}  // namespace aula
