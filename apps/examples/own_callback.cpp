// An audio callback of the program; a thread that requests 256 samples every 5.3 ms represents the
// device. A source is added, circles the head and is removed during playback.
#include <aula/auralizer.h>
#include <aula/engine/scene_file.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <thread>

int main(int argc, char** argv) {
    if (argc != 2) return std::fputs("usage: own_callback SCENE\n", stderr), 2;
    aula::Scene scene = aula::load_scene(argv[1]).scene;
    scene.sources.clear();
    aula::Auralizer auralizer(scene);
    const aula::Vec3 head = scene.listener.pose.position;
    const aula::SourceId tone = auralizer.add_source({.position = head + aula::Vec3(1, 0, 0)});

    constexpr int kBlock = 256;
    constexpr int kBlocks = 600;
    double left = 0, right = 0, phase = 0;
    const auto callback = [&] {  // [audio thread] never waits, allocates or locks
        std::array<float, kBlock> input{};
        std::array<std::array<float, kBlock>, 2> output{};
        for (float& sample : input) {
            sample = 0.2F * static_cast<float>(std::sin(phase));
            phase += 2 * 3.14159265 * 440 / auralizer.sample_rate_hz();
        }
        const std::array<float*, 2> outputs{output[0].data(), output[1].data()};
        const aula::SourceSignal signal{tone, input.data()};
        auralizer.render({&signal, 1}, outputs, kBlock);
        for (const float sample : output[0]) left += double{sample} * double{sample};
        for (const float sample : output[1]) right += double{sample} * double{sample};
    };
    std::jthread device([&] {
        const auto period = std::chrono::duration<double>(kBlock / auralizer.sample_rate_hz());
        const auto start = std::chrono::steady_clock::now();
        for (int block = 0; block < kBlocks; ++block) {
            std::this_thread::sleep_until(
                start + std::chrono::duration_cast<std::chrono::nanoseconds>(block * period));
            callback();
        }
    });
    for (int step = 0; step < 90; ++step) {  // [any other thread] 30 poses per second
        const auto angle = static_cast<float>(step) * 0.07F;
        auralizer.set_source(tone,
                             {.position = head + aula::Vec3(std::cos(angle), std::sin(angle), 0)});
        std::this_thread::sleep_for(std::chrono::milliseconds(33));
    }
    auralizer.remove_source(tone);
    device.join();
    const aula::AuralizerStatus status = auralizer.status();
    std::printf("%lld samples, %llu frames of %.1f ms; left %.4f, right %.4f rms\n",
                static_cast<long long>(status.samples),
                static_cast<unsigned long long>(status.frames), status.frame_mean_ms,
                std::sqrt(left / (kBlock * kBlocks)), std::sqrt(right / (kBlock * kBlocks)));
}
