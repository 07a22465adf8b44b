// A game's loop: two rooms and a door that swings open while noise plays behind it.
// Prints the level at the listener, a line for each quarter of a second.
#include <aula/auralizer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

using aula::Vec3;

/// Adds a box with its corners at `low` and `high`. Surfaces reflect on both sides.
static std::size_t add_box(aula::Scene& scene, const Vec3& low, const Vec3& high,
                           const char* material, const char* name) {
    std::vector<Vec3> v;
    for (int i = 0; i < 8; ++i)
        v.emplace_back(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z);
    // clang-format off
    return scene.add_object(v, {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                                {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}},
                            material, name);
    // clang-format on
}

int main() {
    aula::Scene scene;
    add_box(scene, {0, 0, 0}, {10, 5, 3}, "plaster", "walls");
    add_box(scene, {5, 0, 0}, {5.2F, 4, 3}, "brick", "wall beside the door");
    const std::size_t door = add_box(scene, {0, 0, 0}, {0.1F, 1, 3}, "wood", "door");
    scene.objects[door].movable = true;
    scene.objects[door].translation = {5.05F, 4, 0};  // the hinge

    aula::AuralizerOptions options;
    options.clock = aula::RenderClock::exact;  // a game uses the default: real_time
    aula::Auralizer auralizer(scene, options);
    const aula::SourceId noise = auralizer.add_source({.position = {2, 2.5F, 1.5F}});
    auralizer.set_listener({.position = {8, 2.5F, 1.7F}, .yaw_rad = 3.14F});

    std::minstd_rand random(1);
    std::uniform_real_distribution<float> uniform(-0.3F, 0.3F);
    std::array<float, 800> input{}, left{}, right{};
    const std::array<float*, 2> outputs{left.data(), right.data()};
    double sum = 0;
    for (int frame = 1; frame <= 240; ++frame) {  // 60 per second
        const float open = std::clamp(static_cast<float>(frame - 120) / 30, 0.0F, 1.0F);
        auralizer.set_transform(door, aula::RigidTransform(aula::Pose{.yaw_rad = -1.4F * open}));
        for (float& sample : input) sample = uniform(random);
        const aula::SourceSignal signal{noise, input.data()};
        auralizer.render({&signal, 1}, outputs, static_cast<int>(input.size()));
        for (const float sample : left) sum += double{sample} * double{sample};
        if (frame % 15 != 0) continue;
        std::printf("%4.2f s  door %3.0f %% open  level %6.1f dB\n", frame / 60.0,
                    100 * double{open}, 10 * std::log10(sum / (15 * 800) + 1e-20));
        sum = 0;
    }
}
