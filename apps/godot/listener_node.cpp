#include "apps/godot/listener_node.h"

#include "apps/godot/notifications.h"
#include "apps/godot/room_node.h"

namespace aula::godot {

void ListenerNode::notified(int notification) {
    if (notification == kPostEnterTree) {
        object().call("add_to_group", kRoomPartsGroup);
        join();
        if (room_ == nullptr)
            log_error("AulaListener3D " + object().call("get_path").to_string() +
                      ": no AulaRoom is above it or in the tree");
    } else if (notification == kExitTree && room_ != nullptr) {
        room_->remove(*this);
        room_ = nullptr;
    }
}

void ListenerNode::join() {
    if (room_ != nullptr) return;
    room_ = RoomNode::of(object());
    if (room_ != nullptr) room_->add(*this);
}

void ListenerNode::set_bus(const std::string& name) {
    bus_ = name;
    if (room_ != nullptr) room_->choose_bus();
}

std::unique_ptr<ClassEntry> register_listener() {
    auto entry = std::make_unique<ClassEntry>(
        "AulaListener3D", "Node3D",
        [](Object object) -> Instance* { return new ListenerNode(object); }, true, true);
    entry->add_property(
        {.name = "bus", .type = GDEXTENSION_VARIANT_TYPE_STRING},
        method_of<ListenerNode>([](ListenerNode& self, const Value*) { return Value(self.bus()); }),
        method_of<ListenerNode>([](ListenerNode& self, const Value* arguments) {
            self.set_bus(arguments[0].to_string());
            return Value();
        }));
    return entry;
}

}  // namespace aula::godot
