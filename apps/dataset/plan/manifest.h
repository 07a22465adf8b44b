#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "apps/dataset/plan/distribution.h"
#include "apps/dataset/plan/settings.h"
#include "aula/engine/scene.h"
#include "engine/input/json.h"

namespace aula {

/// Boxes from the origin to their sizes.
struct BoxRooms {
    std::vector<NumberDistribution> size_m;  ///< along x, y, z
    MaterialDistribution walls;
    std::optional<MaterialDistribution> floor;    ///< absent: as the walls
    std::optional<MaterialDistribution> ceiling;  ///< absent: as the walls
};

/// Scene files.
struct SceneRooms {
    NameDistribution files;        ///< relative to the manifest's folder
    std::optional<Bounds> region;  ///< of all positions; absent: the bounds of the geometry
    std::map<std::string, MaterialDistribution> materials;  ///< by the names in the scenes
};

/// A number of scenes of one kind.
struct RoomGroup {
    std::uint64_t count = 0;
    std::variant<BoxRooms, SceneRooms> rooms;
};

/// A straight, level walk through positions at equal distances.
struct Walk {
    int steps = 2;                   ///< positions
    NumberDistribution length_m{1};  ///< from the first to the last one
};

/// Where sources or receivers are.
struct Placement {
    NumberDistribution count{1};            ///< per scene
    std::optional<Walk> walk;               ///< each of them walks; absent: it rests
    float wall_clearance_m = 0.5F;          ///< smallest distance to surfaces
    float source_clearance_m = 0;           ///< smallest distance to sources
    std::optional<NumberDistribution> z_m;  ///< height; absent: anywhere
    NumberDistribution yaw_deg{0};
    NumberDistribution pitch_deg{0};

    /// Positions of each of them.
    int steps() const { return walk ? walk->steps : 1; }
};

/// A dataset as its author describes it: distributions of rooms and positions.
struct Manifest {
    std::filesystem::path file;
    JsonValue json;  ///< of the file
    DatasetSettings settings;
    std::vector<RoomGroup> groups;
    Placement sources;
    NameDistribution directivity{"omni"};  ///< of the sources
    Placement receivers;

    /// Number of scenes of all groups.
    std::uint64_t scenes() const;
};

/// True if a file can be read and begins as a manifest: "aula_dataset" is in its first kilobyte.
bool is_manifest(const std::filesystem::path& file);

/// Reads a manifest (docs/datasets.md). Scene files are not opened. Throws InputError.
Manifest read_manifest(const std::filesystem::path& file);

}  // namespace aula
