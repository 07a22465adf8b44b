// Plays a scene on the silent device, for half a second and until two frames have been seen, at
// most a minute: use_devices SCENE
#include <aula/devices/scene_player.h>
#include <aula/engine/scene_file.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <thread>

namespace {

struct Played {
    aula::ScenePlayerStatus status;
    float peak = 0;
};

/// Plays until the end, or until this number of frames and sound have been seen.
Played play(const char* scene, double duration_s, std::uint64_t frames) {
    aula::ScenePlayerOptions options;
    options.device = aula::AudioDevice::kNone;
    options.duration_s = duration_s;
    aula::ScenePlayer player(aula::load_scene(scene).scene, options);
    Played played;
    while (!played.status.finished && !(played.status.frames >= frames && played.peak > 0)) {
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
        played.status = player.status();
        played.peak = std::max(played.peak, played.status.peak);
    }
    std::printf("%.1f s, %llu frames, largest sample %.3f\n", played.status.time_s,
                static_cast<unsigned long long>(played.status.frames),
                static_cast<double>(played.peak));
    return played;
}

}  // namespace

int main(int, char** argv) {
    const Played whole = play(argv[1], 0.5, UINT64_MAX);
    if (whole.status.time_s != 0.5 || !(whole.peak > 0)) return 1;
    const Played long_one = play(argv[1], 60, 2);
    return long_one.status.frames >= 2 && long_one.peak > 0 ? 0 : 1;
}
