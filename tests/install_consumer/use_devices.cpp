// Plays a scene on the silent device until two frames and sound have been seen, for at most a
// minute: use_devices SCENE
#include <aula/devices/scene_player.h>
#include <aula/engine/scene_file.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <thread>

int main(int, char** argv) {
    aula::ScenePlayerOptions options;
    options.device = aula::AudioDevice::kNone;
    options.duration_s = 60;
    aula::ScenePlayer player(aula::load_scene(argv[1]).scene, options);
    aula::ScenePlayerStatus status;
    float peak = 0;
    const auto complete = [&] { return status.frames > 1 && peak > 0; };
    while (!status.finished && !complete()) {
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
        status = player.status();
        peak = std::max(peak, status.peak);
    }
    std::printf("%.1f s, %llu frames, largest sample %.3f\n", status.time_s,
                static_cast<unsigned long long>(status.frames), static_cast<double>(peak));
    return status.time_s > 0 && complete() ? 0 : 1;
}
