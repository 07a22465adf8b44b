#include <memory>
#include <vector>

#include "apps/godot/bus.h"
#include "apps/godot/listener_node.h"
#include "apps/godot/room_node.h"
#include "apps/godot/source_node.h"

namespace {

using namespace aula::godot;

using Classes = std::vector<std::unique_ptr<ClassEntry>>;

void initialize(void* classes, GDExtensionInitializationLevel level) {
    if (level != GDEXTENSION_INITIALIZATION_SCENE) return;
    auto& entries = *static_cast<Classes*>(classes);
    for (const auto add : {register_bus_effect, register_bus_effect_instance, register_material,
                           register_body, register_room, register_source, register_listener})
        entries.push_back(add());
}

void deinitialize(void* classes, GDExtensionInitializationLevel level) {
    if (level != GDEXTENSION_INITIALIZATION_SCENE) return;
    RoomNode::wait_for_abandoned();
    auto& entries = *static_cast<Classes*>(classes);
    while (!entries.empty()) entries.pop_back();
}

}  // namespace

/// What aula.gdextension names as the entry of the library.
extern "C" __attribute__((visibility("default"))) GDExtensionBool aula_godot_init(
    GDExtensionInterfaceGetProcAddress find, GDExtensionClassLibraryPtr library,
    GDExtensionInitialization* initialization) {
    static Classes classes;
    if (!load_api(find, library)) return 0;
    initialization->minimum_initialization_level = GDEXTENSION_INITIALIZATION_SCENE;
    initialization->userdata = &classes;
    initialization->initialize = initialize;
    initialization->deinitialize = deinitialize;
    return 1;
}
