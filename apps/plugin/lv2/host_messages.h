#pragma once

#include <lv2/atom/atom.h>
#include <lv2/atom/forge.h>
#include <lv2/state/state.h>
#include <lv2/urid/urid.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "apps/plugin/message_queue.h"
#include "apps/plugin/plugin_room.h"
#include "aula/audio/realtime.h"

namespace aula::plugin {

/// What a host tells a plugin at a sample of a call.
struct HostEvent {
    enum class Kind { set, get, position };

    Kind kind = Kind::get;
    std::int64_t offset = 0;              ///< sample in the call
    Property property = Property::scene;  ///< of set
    std::string_view text{};              ///< of set
    std::int64_t frame = 0;               ///< of position: sample of the transport
    double speed = 0;                     ///< of position: 0: stopped
};

/// A property of a state that this version of the plugin does not know.
struct UnknownProperty {
    std::string uri;
    std::uint32_t type = 0;  ///< as the host maps it
    std::uint32_t flags = 0;
    std::vector<char> value;
};

/// What a state holds beside the ports.
struct StoredFiles {
    RoomFiles files{};
    std::vector<UnknownProperty> unknown{};
};

/// Reads and writes the messages of the event ports and the state of a plugin. Without a map of
/// URIs it does nothing.
class HostMessages {
 public:
    explicit HostMessages(const LV2_URID_Map* map);

    /// Begins a call; null: a port is not connected. [audio thread]
    void begin(const LV2_Atom_Sequence* control, LV2_Atom_Sequence* notify) noexcept;
    /// The next event of the call that a plugin understands. [audio thread]
    std::optional<HostEvent> next() noexcept;
    /// Sends a property to the host; false if there is no room for it. [audio thread]
    bool send(const Message& message) noexcept;
    /// Ends the call. [audio thread]
    void end() noexcept;

    /// Stores files in a state, with the list of its keys: a host does not tell which keys a state
    /// has, and an older version has to keep those that it does not know. [not the audio thread]
    LV2_State_Status save(const StoredFiles& stored, LV2_State_Store_Function store,
                          LV2_State_Handle handle, const LV2_Feature* const* features) const;
    /// The files of a state; `present` are those that it does not contain. [not the audio thread]
    StoredFiles restore(const RoomFiles& present, LV2_State_Retrieve_Function retrieve,
                        LV2_State_Handle handle, const LV2_Feature* const* features) const;

 private:
    struct Urids {
        LV2_URID path, string, urid, object, blank, integer, whole, single, real, set, get,
            property, value, position, frame, speed, seed, keys;
        std::array<LV2_URID, kProperties> properties;
    };

    std::optional<HostEvent> event_of(const LV2_Atom_Event& event) const noexcept;
    std::optional<HostEvent> set_event(const LV2_Atom_Object& object) const noexcept;
    double number(const LV2_Atom* atom, double otherwise) const noexcept;

    std::vector<UnknownProperty> unknown_properties(LV2_State_Retrieve_Function retrieve,
                                                    LV2_State_Handle handle) const;

    bool mapped_ = false;
    LV2_URID_Map map_{};
    Urids urids_{};
    LV2_Atom_Forge forge_{};
    LV2_Atom_Forge_Frame sequence_{};
    const LV2_Atom_Sequence* control_ = nullptr;
    const LV2_Atom_Event* next_ = nullptr;
    bool writes_ = false;
};

}  // namespace aula::plugin
