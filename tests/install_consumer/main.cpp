#include "apps/session/session.h"
#include "engine/scene/scene_file.h"

int main(int, char** argv) {
    const auto loaded = aula::load_scene(argv[1]);
    aula::SessionOptions options;
    options.duration_s = 1;
    aula::Session session(loaded.scene, options);
    return session.render(argv[2]) ? 0 : 1;
}
