#include "apps/plugin/default_room.h"

#include "aula/engine/scene_file.h"

namespace aula {

extern const char* const kDefaultRoomJson;  // scenes/default.json, embedded by the build

namespace plugin {

Scene default_room() { return parse_scene(kDefaultRoomJson, "default.json", {}).scene; }

}  // namespace plugin

}  // namespace aula
