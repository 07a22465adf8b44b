#pragma once

#include <cstdint>
#include <string>

#include "apps/dataset/shards/shard_reader.h"

namespace aula {

/// What is known before the items are merged.
struct MergeSizes {
    std::uint64_t responses = 0;
    std::uint64_t samples = 1;  ///< of the longest response, at least 1
};

/// Receives the items of a dataset with a response in their order. There are as many as MergeSizes
/// says, and none is longer.
class MergeTarget {
 public:
    virtual ~MergeTarget() = default;
    virtual void add(const ShardItem& item) = 0;
    virtual void finish() = 0;
    /// The file of an item for the index.
    virtual std::string file_of(const ShardItem& item) const = 0;
};

}  // namespace aula
