#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "apps/window/model/undo.h"
#include "apps/window/model/window_options.h"
#include "aula/engine/scene.h"
#include "aula/engine/scene_file.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// A scene as the window plays it: all signals loop.
struct OpenedScene {
    std::shared_ptr<const Scene> scene;
    std::shared_ptr<const LoadedScene> read;  ///< the scene as read from its file
    std::unique_ptr<RayScene> rays;
    std::filesystem::path file;
    std::filesystem::file_time_type file_time;  ///< before it was read
};
/// Throws InputError. [any thread]
OpenedScene open_scene(const WindowOptions& options, const std::filesystem::path& file);

/// The scene that the window shows, with its file, the history of its edits, and all that depends
/// on the scene: ray scene, bounds, selected surface. [window's thread]
class EditedScene {
 public:
    /// Positions of the sources that the user has set; a source without one follows its trajectory.
    /// May be shorter than the list of sources.
    using SourcePositions = std::vector<std::optional<Vec3>>;

    /// A surface picked with the mouse.
    struct Surface {
        std::vector<std::uint32_t> triangles;
        std::uint32_t picked = 0;
        float area_m2 = 0;
    };

    /// What an edit has changed.
    struct Change {
        bool scene = false;
        bool sources = false;  ///< their number or names
    };

    explicit EditedScene(OpenedScene opened);

    /// Shows another scene and clears the history.
    void restart(OpenedScene opened);

    const Scene& scene() const { return *history_.now().scene; }
    const std::shared_ptr<const Scene>& shared_scene() const { return history_.now().scene; }
    const LoadedScene& read() const { return *history_.now().read; }
    const SourcePositions& source_positions() const { return history_.now().source_positions; }
    const std::filesystem::path& file() const { return file_; }

    const RayScene& rays() const { return *rays_; }
    const Bounds& bounds() const { return bounds_; }
    std::uint64_t version() const { return version_; }  ///< counts the changes of the scene
    std::uint64_t geometry_version() const { return geometry_version_; }

    /// Moves the objects of the ray scene to a time of the scene.
    void move_objects(double time_s);

    // Edits: each is one undo step.
    Change edit(Scene edited, SourcePositions positions);
    /// Consecutive calls form one undo step.
    Change edit_remotely(Scene edited, SourcePositions positions);
    /// Moves sources.
    void move_sources(SourcePositions positions);
    /// Replaces the scene by that of its edited file.
    Change reload(OpenedScene opened);

    bool can_undo() const { return history_.can_undo(); }
    bool can_redo() const { return history_.can_redo(); }
    Change undo();
    Change redo();

    void pick(std::uint32_t triangle);
    void deselect() { surface_.reset(); }
    const std::optional<Surface>& surface() const { return surface_; }

    /// True once after each change of the file, whose time is read every 0.5 s.
    bool file_changed(double now_s);

 private:
    /// The state that undo restores.
    struct Document {
        std::shared_ptr<const Scene> scene;
        std::shared_ptr<const LoadedScene> read;
        SourcePositions source_positions;
    };

    Change change(Document document);
    Change update(const Scene& before, std::unique_ptr<RayScene> rays);
    void take_geometry(std::unique_ptr<RayScene> rays);

    std::filesystem::path file_;
    std::filesystem::file_time_type file_time_;
    double file_checked_s_ = 0;
    Undo<Document> history_;
    std::shared_ptr<const Scene> edited_remotely_;  ///< by the last edit_remotely()
    std::unique_ptr<RayScene> rays_;
    Bounds bounds_;
    std::uint64_t version_ = 0;
    std::uint64_t geometry_version_ = 0;
    std::optional<Surface> surface_;
};

}  // namespace aula
