#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "apps/dataset/plan/room_space.h"
#include "apps/dataset/plan/settings.h"
#include "aula/engine/scene.h"
#include "engine/input/json_reader.h"

namespace aula {

/// One scene of a plan: a line of plan.jsonl. Its items are the pairs of its sources and receivers,
/// source by source.
struct PlannedScene {
    std::uint64_t index = 0;
    std::uint64_t first_item = 0;
    std::uint64_t items = 0;
    std::uint64_t seed = 0;       ///< below 2^53; depends on the manifest's seed and the index
    JsonValue::Object geometry;   ///< {"box": [..]} or {"file": .., "sha256": ..}
    JsonValue::Object materials;  ///< those that replace the geometry's, as in a scene file
    JsonValue::Array sources;     ///< as in a scene file
    std::vector<PlannedPose> receivers;
    std::string error;  ///< why the scene has no positions; else empty

    /// The size of a box along x, y, z; empty for a scene file.
    std::optional<std::array<double, 3>> box_m() const;

    std::size_t source_of(std::uint64_t item) const {
        return static_cast<std::size_t>((item - first_item) / receivers.size());
    }
    std::size_t receiver_of(std::uint64_t item) const {
        return static_cast<std::size_t>((item - first_item) % receivers.size());
    }
};

/// The position and angles of a source or a receiver of a plan. Throws InputError.
PlannedPose read_pose(const JsonReader& json);

/// The line of a plan, without the line feed.
std::string scene_line(const PlannedScene& scene);

/// The scene of a line; messages name the file `name`. Throws InputError unless the line has all
/// members of a PlannedScene and its numbers of items, sources and receivers agree. The contents of
/// materials and sources are checked by build_scene().
PlannedScene read_scene_line(const std::string& line, const std::string& name);

/// Reads the scene files of a dataset; keeps the newest. [any thread]
class SceneFiles {
 public:
    /// A scene without its sources, and the hash of its content (scene_state).
    struct File {
        Scene scene;
        std::string sha256;
    };

    /// `folder` is that of the manifest.
    explicit SceneFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}

    /// Throws InputError.
    std::shared_ptr<const File> read(const std::string& name);

 private:
    std::filesystem::path folder_;
    std::mutex mutex_;
    std::map<std::string, std::shared_ptr<const File>> files_;
};

/// The scene of a plan's line with its sources. Throws InputError, for instance if a file is
/// missing or has changed since the plan.
Scene build_scene(const PlannedScene& planned, const DatasetSettings& settings, SceneFiles& files);

/// SHA-256 of all that affects the results of a scene (scene_state).
std::string scene_hash(const Scene& scene);

/// The microphones of all receivers, receiver by receiver.
std::vector<Pose> microphone_poses(const PlannedScene& planned, const DatasetSettings& settings);

}  // namespace aula
