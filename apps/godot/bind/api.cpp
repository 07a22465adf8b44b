#include "apps/godot/bind/api.h"

namespace aula::godot {

Api api;

bool load_api(GDExtensionInterfaceGetProcAddress find, GDExtensionClassLibraryPtr library) {
    api.library = library;
    bool found = true;
#define AULA_GODOT_FIND(name, type)                                       \
    api.name = reinterpret_cast<GDExtensionInterface##type>(find(#name)); \
    found = found && api.name != nullptr;
    AULA_GODOT_FUNCTIONS(AULA_GODOT_FIND)
#undef AULA_GODOT_FIND
    return found;
}

void log_error(const std::string& message) {
    api.print_error_with_message(message.c_str(), message.c_str(), "Aula", "aula", 0, true);
}

}  // namespace aula::godot
