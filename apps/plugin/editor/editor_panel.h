#pragma once

#include <imgui.h>

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/drawing/room_section.h"
#include "apps/plugin/editor/editor_host.h"
#include "apps/plugin/editor/folder_listing.h"
#include "apps/plugin/editor/room_sketch.h"

namespace aula::plugin {

/// The contents of an editor in Dear ImGui: plan and side view, in which source and listener are
/// dragged, the choice of the room, its reverberation times, the level.
class EditorPanel {
 public:
    explicit EditorPanel(EditorHost& host);
    ~EditorPanel();
    EditorPanel(const EditorPanel&) = delete;
    EditorPanel& operator=(const EditorPanel&) = delete;

    /// Reads the host. True if draw() would draw something else than the last time.
    bool follow();
    /// Draws the whole window.
    void draw();

 private:
    /// What is drawn, but for the room.
    struct Shown {
        ControlValues values{};
        RoomFiles files;
        int level_db = 0;
        std::string status;
        const SketchedRoom* room = nullptr;
        bool has_times = false;
    };
    /// Source or listener between press and release.
    struct Drag {
        bool is_listener;
        ImGuiID view;
        std::vector<Control> controls;  ///< that have begun to change
    };

    void cut();
    void draw_views(ImVec2 size);
    void draw_view(const char* name, const RoomSection& section, int up, ImVec2 low, float scale);
    void begin_drag(ImGuiID view, const std::array<ImVec2, 2>& marks);
    void drag_to(const Vec3& place);
    void end_drag();
    void draw_side_panel();
    void draw_rooms();
    void draw_files();
    void draw_times();
    void draw_level();
    void set(Control control, float value);
    Vec3 source_place() const;
    Pose listener() const;

    EditorHost& host_;
    RoomSketch sketch_;
    Shown shown_;
    std::shared_ptr<const SketchedRoom> room_;
    RoomSection plan_;
    RoomSection side_;
    std::optional<Vec3> cut_at_;  ///< where the plan and the side view were cut
    std::optional<Drag> drag_;
    std::optional<FolderListing> browsed_;  ///< from which a scene is chosen
};

}  // namespace aula::plugin
