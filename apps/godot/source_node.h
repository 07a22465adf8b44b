#pragma once

#include <memory>
#include <string>

#include "apps/godot/bus.h"
#include "apps/godot/room_scene.h"
#include "apps/godot/sound/source_input.h"

namespace aula::godot {

class RoomNode;

/// AulaSource3D: plays a stream, through a player and a bus of its own, at a place in the room.
/// [main thread]
class SourceNode final : public Instance {
 public:
    using Instance::Instance;

    void notified(int notification) override;

    SourceInput& input() { return *input_; }
    /// Joins a room, if it is in none and there is one.
    void join();
    /// The pose of the node in the frame of the room.
    aula_pose pose(const Transform& frame) const;
    /// Adds the source to a scene or to a room. Returns its number; throws RoomError.
    aula_source add_to(aula_scene* scene, const aula_pose& pose) const;
    aula_source add_to(aula_room* room, const aula_pose& pose) const;
    /// The room plays from now on, with the source at a pose and with a directivity.
    void start(const aula_pose& pose, const std::string& heard_directivity);
    /// Whether it is in the room with another directivity than it has now.
    bool has_new_directivity() const {
        return input_->number != 0 && directivity != heard_directivity_;
    }
    /// Moves the source where its node is.
    void move(aula_room* room, const Transform& frame);
    /// The room is gone. What plays begins again in the next one.
    void leave();
    SavedSource saved(const Transform& frame) const;

    void play();
    void stop();
    bool is_playing() const;
    /// The AudioStreamPlayer; null before the node has been in the tree.
    Object player() const { return player_; }

    void set_stream(const Value& stream);
    void set_gain_db(double gain_db);

    Value stream;
    double gain_db = 0;
    std::string directivity = "omni";
    bool autoplay = false;

 private:
    void enter();
    /// The path from the room.
    std::string name() const;

    RoomNode* room_ = nullptr;
    std::shared_ptr<SourceInput> input_ = std::make_shared<SourceInput>();
    std::unique_ptr<Bus> bus_;
    Object player_;
    aula_pose pose_{};                     ///< the newest of the room that plays
    std::string pose_error_, gain_error_;  ///< of the newest
    std::string heard_directivity_;
    bool starts_ = false;  ///< as soon as the room can be heard
};

std::unique_ptr<ClassEntry> register_source();

}  // namespace aula::godot
