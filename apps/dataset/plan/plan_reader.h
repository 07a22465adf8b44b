#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "apps/dataset/plan/plan.h"
#include "apps/dataset/plan/planned_scene.h"
#include "process/regular_file.h"

namespace aula {

/// Reads the plan of a folder, of plan.jsonl the settings only. The shards cover all scenes and
/// items without a gap, and their numbers are possible for a manifest. Throws InputError, also for
/// a plan of another version of Aula.
Plan read_plan(const std::filesystem::path& folder);

/// Reads all of plan.jsonl. Throws InputError if it is not the file that was planned, or if
/// plan.json divides other scenes.
void check_scenes(const Plan& plan);

/// The lines of plan.jsonl.
class PlanLines {
 public:
    /// Throws InputError if the file cannot be read.
    explicit PlanLines(const Plan& plan);

    const std::string& name() const { return name_; }

    /// Offset of the next line in the file.
    std::uint64_t offset() const { return next_; }
    void seek(std::uint64_t offset) { next_ = offset; }

    /// The next line without its line feed; empty at the end of the file. Throws InputError if it
    /// is longer than that of any scene.
    std::optional<std::string> next();

 private:
    std::string name_;
    RegularFile file_;
    std::string buffer_;           ///< bytes of the file
    std::uint64_t buffer_at_ = 0;  ///< offset of the buffer in the file
    std::uint64_t next_ = 0;
};

/// Reads the scenes of a shard in their order.
class PlanReader {
 public:
    /// Throws InputError if the lines of the shard are not those that were planned.
    PlanReader(const Plan& plan, const ShardRange& shard);

    /// The next scene; empty at the shard's end. Throws InputError unless its numbers follow those
    /// of the previous one and end with those of the shard.
    std::optional<PlannedScene> next();

 private:
    PlanLines lines_;
    std::uint64_t scene_;
    std::uint64_t end_scene_;
    std::uint64_t item_;
    std::uint64_t end_item_;
};

}  // namespace aula
