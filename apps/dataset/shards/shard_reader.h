#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "apps/dataset/base/tar.h"
#include "apps/dataset/plan/plan_reader.h"
#include "aula/engine/bands.h"

namespace aula {

/// What a shard contains.
struct ShardContents {
    std::uint64_t responses = 0;
    std::uint64_t errors = 0;  ///< items without a response
};

/// An item of a shard. All members agree with the plan and with each other.
struct ShardItem {
    std::uint64_t index = 0;
    std::uint64_t scene = 0;
    std::uint64_t seed = 0;
    std::string json;   ///< its description
    std::string error;  ///< why it has no response, on one line; else empty

    // Of an item with a response.
    std::optional<std::array<double, 3>> box_m;  ///< size of the room; empty for a scene file
    std::string scene_file;                      ///< else empty
    PlannedPose source;
    PlannedPose receiver;
    std::string scene_sha256;  ///< 64 hexadecimal digits
    /// [microphone][band], as many as the settings' microphones; NaN if absent
    std::vector<std::array<double, kBandCount>> t30_s;
    std::uint64_t samples = 0;  ///< at least 1
    std::string wav;            ///< its response: is_wav() holds
};

/// Reads a shard, which may be a file of strangers: the hash of an item has no key. next() reads
/// headers only; what read() returns is checked against the plan.
class ShardReader {
 public:
    /// Keeps a reference to the plan. Throws InputError if the file cannot be read.
    ShardReader(const Plan& plan, std::size_t shard);

    /// Goes to the next item. Returns false after the last one. Throws InputError if the archive
    /// is truncated or damaged, or is not one of the plan's shard.
    bool next();

    // The item to which next() went.

    std::uint64_t item() const { return item_ - 1; }
    bool has_response() const { return wav_.has_value(); }
    /// Samples of its response by the size of the file; 0 if read() will refuse it.
    std::uint64_t samples() const;
    /// Throws InputError, "SHARD: item 0: what is wrong", if the item is damaged or does not agree
    /// with the plan.
    ShardItem read();

 private:
    const PlannedScene& planned();
    void read_response(const JsonReader& json, ShardItem& item);

    const Plan& plan_;
    const ShardRange& range_;
    TarReader tar_;
    std::optional<TarMember> ahead_;  ///< the member after the item
    std::uint64_t item_;              ///< the next one
    TarMember json_;
    std::optional<TarMember> wav_;  ///< absent: the item has an error
    std::optional<PlanReader> scenes_;
    std::optional<PlannedScene> scene_;  ///< of the newest read()
};

/// The contents of a shard; empty unless its archive is complete and belongs to the plan.
std::optional<ShardContents> find_shard(const Plan& plan, std::size_t shard);

}  // namespace aula
