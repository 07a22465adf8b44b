#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/dataset/plan/manifest.h"
#include "apps/dataset/plan/planned_scene.h"
#include "apps/dataset/plan/settings.h"

namespace aula {

/// The scenes and items of a shard.
struct ShardRange {
    std::uint64_t first_scene = 0;
    std::uint64_t end_scene = 0;
    std::uint64_t first_item = 0;
    std::uint64_t end_item = 0;
    std::uint64_t offset = 0;  ///< of its first line in plan.jsonl, bytes
    std::string sha256;        ///< of the line with the settings and its own lines
};

/// The plan of a dataset in its folder. plan.jsonl has a line with the settings and one for each
/// scene; it does not depend on the number of shards. plan.json divides it into shards.
struct Plan {
    std::filesystem::path folder;
    std::string sha256;                     ///< of plan.jsonl
    std::filesystem::path manifest_folder;  ///< to which scene files are relative
    DatasetSettings settings;
    std::uint64_t scenes = 0;
    std::uint64_t items = 0;
    std::uint64_t empty_scenes = 0;  ///< scenes without positions
    std::vector<ShardRange> shards;

    /// "shard-00003.tar" in the folder.
    std::filesystem::path shard_file(std::size_t shard) const;

    /// The name of an item in files, for instance "000123".
    static std::string item_name(std::uint64_t item);
};

/// Draws all scenes of a manifest and writes the plan to a folder, which is created. The same
/// manifest and number of shards give the same bytes. Returns false when `continues` does; nothing
/// is left then. Throws InputError for a bad manifest or scene file, more shards than
/// scenes, and a folder that has shards of another plan; Failure if writing fails.
bool write_plan(const Manifest& manifest, const std::filesystem::path& folder, std::size_t shards,
                const std::function<bool()>& continues);

/// Reads the plan of a folder, of plan.jsonl the settings only. Throws InputError, also for a plan
/// of another version of Aula.
Plan read_plan(const std::filesystem::path& folder);

/// Reads all of plan.jsonl. Throws InputError if it is not the file that was planned.
void check_scenes(const Plan& plan);

/// Reads the scenes of a shard in their order.
class PlanReader {
 public:
    /// Throws InputError if the lines of the shard are not those that were planned.
    PlanReader(const Plan& plan, const ShardRange& shard);

    /// The next scene; empty at the shard's end. Throws InputError.
    std::optional<PlannedScene> next();

 private:
    std::filesystem::path file_;
    std::ifstream stream_;
    std::uint64_t left_;
};

}  // namespace aula
