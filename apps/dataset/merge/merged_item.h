#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "apps/dataset/plan/room_space.h"
#include "apps/dataset/plan/settings.h"
#include "apps/dataset/shards/shard.h"

namespace aula {

/// An item with a response, as it is merged.
struct MergedItem {
    std::uint64_t index = 0;
    std::uint64_t scene = 0;
    std::uint64_t seed = 0;
    JsonValue::Object geometry;
    PlannedPose source;
    PlannedPose receiver;
    std::vector<std::vector<double>> t30_s;  ///< [microphone][band]; NaN if absent
    std::uint64_t samples = 0;
    std::string scene_sha256;
    std::string json;  ///< its description
    std::string wav;   ///< its response

    /// [channel][sample]
    std::vector<std::vector<float>> channels() const;
};

/// What is known before the items are merged.
struct MergeSizes {
    std::uint64_t responses = 0;
    std::uint64_t samples = 0;  ///< of the longest response
};

/// Receives the items of a dataset with a response in their order.
class MergeTarget {
 public:
    virtual ~MergeTarget() = default;
    virtual void add(const MergedItem& item) = 0;
    virtual void finish() = 0;
    /// The file of an item for the index.
    virtual std::string file_of(const MergedItem& item) const = 0;
};

/// Reads an item of a shard. Throws InputError.
MergedItem read_item(const TarReader& tar, const ItemMembers& members);

}  // namespace aula
