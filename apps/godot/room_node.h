#pragma once

#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/godot/bus.h"
#include "apps/godot/room_scene.h"
#include "apps/godot/sound/room_output.h"

namespace aula::godot {

class ListenerNode;
class SourceNode;

/// The group of the nodes that may join a room.
inline constexpr const char* kRoomPartsGroup = "aula_room_parts";

/// A source of a scene that another thread makes audible.
struct SourceInMaking {
    SourceNode* node = nullptr;  ///< null: gone meanwhile
    aula_source number = 0;      ///< in a new room; 0: it cannot be used
    aula_pose pose{};
    std::string directivity;
};

/// A scene that another thread makes audible.
struct RoomInMaking {
    std::future<RoomHandle> room;  ///< the one that plays, or a new one; throws RoomError
    aula_options options{};        ///< of a new one
    std::vector<MovingObject> moving;
    std::vector<SourceInMaking> sources;
    aula_pose head{};
};

/// AulaRoom: makes the geometry below it audible. It renders into a bus of its own. [main thread]
class RoomNode final : public Instance {
 public:
    using Instance::Instance;
    ~RoomNode() override;

    /// The room of a node: the nearest above it, else the first in the tree; null if there is none.
    static RoomNode* of(Object node);

    void notified(int notification) override;

    /// Waits for the threads that make scenes audible for nodes that have left the tree.
    static void wait_for_abandoned();

    /// False, and an error in the log, if the room has as many sources as it may.
    bool add(SourceNode& source);
    void remove(SourceNode& source);
    /// The room is heard by one listener: of those that are there the one that came last.
    void add(ListenerNode& listener);
    void remove(const ListenerNode& listener);
    /// Sends the sound to the bus of the listener.
    void choose_bus();
    /// The bus into which the room is rendered.
    const std::string& bus() const { return bus_->name(); }

    /// Reads the geometry, makes it audible on another thread, and plays it as soon as it is there;
    /// in a film waits for it. The room that plays gets the new scene if it can; else a new room
    /// replaces it. While a scene is made audible, does so when that one plays. On errors the old
    /// scene plays on.
    void rebuild();
    /// Writes the scene as it is now. False, and an error in the log, if that fails.
    bool save(const std::string& file);
    aula_room* room() const { return room_.get(); }
    /// The state of the room, zeros if there is none.
    aula_status status() const;
    double load() const { return output_ ? static_cast<double>(output_->load()) : 0; }
    /// Writes the library's message about a node to the log if a result is an error, unless it is
    /// `last_error`; keeps it there.
    void check(int result, Object node, std::string& last_error);

    Value material_value;
    int rays = 0;            ///< 0: the default of Aula
    double ir_length_s = 0;  ///< 0: as long as the room sounds

 private:
    void enter();
    void exit();
    /// Lets the sources and listeners without a room join one.
    void gather();
    void add_monitors();
    void remove_monitors();
    /// Hands the newest poses and transforms to the room.
    void update();
    /// The options of a room that is made now.
    aula_options options() const;
    /// Whether the room that plays can have another scene in place of a new room with the options.
    bool can_exchange(const aula_options& wanted) const;
    /// Begins to make the geometry below the node audible, on another thread. Throws RoomError.
    void begin();
    /// Waits for that, and plays it. Throws RoomError.
    void finish();
    /// Replaces the room that plays.
    void play(RoomHandle room, const RoomInMaking& made);
    /// Whether the room that plays has been made for its sources.
    bool suits() const;
    /// Adds a source to the room that plays, if it has a place.
    void admit(SourceNode& source);
    void write_error(const std::string& message) const;
    void write_error(const SourceNode& source, const std::string& message) const;
    void move_listener(const Transform& frame);
    void move_bodies(const Transform& frame);
    aula_pose listener_pose(const Transform& frame) const;
    const MaterialResource* material() const {
        return instance_of<MaterialResource>(material_value.to_object());
    }

    std::shared_ptr<RoomOutput> output_;
    std::unique_ptr<Bus> bus_;
    RoomHandle room_;
    std::optional<RoomInMaking> making_;
    std::vector<MovingObject> moving_;
    std::vector<SourceNode*> sources_;
    aula_options options_{};    ///< of the room that plays
    bool had_sources_ = false;  ///< when the scene that plays was read
    bool is_outdated_ = false;  ///< the scene is to be read again
    std::vector<ListenerNode*> listeners_;
    bool says_no_listener_ = false;  ///< in the log
    aula_pose head_{};               ///< the newest of the listener
    std::string head_error_;         ///< of head_
    std::vector<std::string> monitors_;
};

std::unique_ptr<ClassEntry> register_room();

}  // namespace aula::godot
