#pragma once

#include <memory>
#include <string>

#include "apps/godot/bind/class_library.h"

namespace aula::godot {

class RoomNode;

/// AulaListener3D: the head that hears a room. [main thread]
class ListenerNode final : public Instance {
 public:
    using Instance::Instance;

    void notified(int notification) override;
    /// Joins a room, if it is in none and there is one.
    void join();
    void set_bus(const std::string& name);
    /// The room is about to be gone.
    void leave() { room_ = nullptr; }

    const std::string& bus() const { return bus_; }

 private:
    RoomNode* room_ = nullptr;
    std::string bus_ = "Master";
};

std::unique_ptr<ClassEntry> register_listener();

}  // namespace aula::godot
