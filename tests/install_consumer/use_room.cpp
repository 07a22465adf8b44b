// Renders a block of a room with a source: use_room SCENE
#include <aula/auralizer.h>
#include <aula/engine/scene_file.h>

#include <array>
#include <cstdio>

int main(int, char** argv) {
    aula::AuralizerOptions options;
    options.clock = aula::RenderClock::exact;
    aula::Auralizer auralizer(aula::load_scene(argv[1]).scene, options);
    const std::array<float, 64> input{1};
    std::array<float, 64> left{};
    std::array<float, 64> right{};
    const std::array<float*, 2> outputs{left.data(), right.data()};
    const aula::SourceSignal signal{auralizer.sources()[0], input.data()};
    auralizer.render({&signal, 1}, outputs, 64);
    std::printf("%d samples of latency\n", auralizer.latency_samples());
}
