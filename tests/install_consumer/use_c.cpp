// Renders a block of a room with a source by the C interface: use_c SCENE
#include <aula.h>

#include <array>
#include <cstdio>

int main(int, char** argv) {
    aula_scene* scene = nullptr;
    aula_room* room = nullptr;
    if (aula_scene_load(argv[1], &scene) != AULA_OK ||
        aula_room_create(scene, nullptr, &room) != AULA_OK) {
        std::fprintf(stderr, "%s\n", aula_message());
        return 1;
    }
    const std::array<float, 64> input{1};
    std::array<float, 64> left{};
    std::array<float, 64> right{};
    const std::array<float*, 2> outputs{left.data(), right.data()};
    const aula_signal signal{1, input.data()};
    const int result = aula_room_process(room, &signal, 1, outputs.data(), 2, 64);
    aula_room_destroy(room);
    aula_scene_destroy(scene);
    return result;
}
