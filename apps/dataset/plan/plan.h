#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "apps/dataset/plan/manifest.h"
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
    static constexpr const char* kFile = "plan.json";
    static constexpr const char* kLines = "plan.jsonl";
    static constexpr const char* kExpected = "the plan of aula dataset plan";
    static constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 30U;  ///< of plan.json

    std::filesystem::path folder;
    std::string sha256;                     ///< of plan.jsonl
    std::filesystem::path manifest_folder;  ///< to which scene files are relative
    DatasetSettings settings;
    std::uint64_t scenes = 0;
    std::uint64_t items = 0;
    std::uint64_t empty_scenes = 0;  ///< scenes without positions
    std::vector<ShardRange> shards;

    /// The lines of the plan: plan.jsonl, or those that have not got this name because a process
    /// has ended.
    std::filesystem::path lines_file() const;

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

}  // namespace aula
