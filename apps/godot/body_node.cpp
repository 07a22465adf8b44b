#include "apps/godot/body_node.h"

namespace aula::godot {
namespace {

void add_switch(ClassEntry& entry, const char* name, bool BodyNode::*value) {
    entry.add_property(
        {.name = name, .type = GDEXTENSION_VARIANT_TYPE_BOOL},
        [value](Instance& self, const Value*) {
            return Value(static_cast<BodyNode&>(self).*value);
        },
        [value](Instance& self, const Value* arguments) {
            static_cast<BodyNode&>(self).*value = arguments[0].to_bool();
            return Value();
        });
}

}  // namespace

std::unique_ptr<ClassEntry> register_body() {
    auto entry = std::make_unique<ClassEntry>(
        "AulaBody3D", "Node3D", [](Object object) -> Instance* { return new BodyNode(object); },
        true, true);
    entry->add_property(
        material_property("material"),
        method_of<BodyNode>([](BodyNode& self, const Value*) { return self.material_value; }),
        method_of<BodyNode>([](BodyNode& self, const Value* arguments) {
            self.material_value = arguments[0];
            return Value();
        }));
    add_switch(*entry, "moving", &BodyNode::moving);
    add_switch(*entry, "audible", &BodyNode::audible);
    return entry;
}

}  // namespace aula::godot
