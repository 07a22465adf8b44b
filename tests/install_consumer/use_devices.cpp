// Plays silence for a short time on the silent device.
#include <aula/devices/device.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <span>
#include <thread>

int main() {
    std::atomic<int> samples{0};
    aula::AudioDevice device(aula::AudioDevice::kNone, 48000, 2, 256,
                             [&](std::span<float* const> outputs, int count) {
                                 for (float* const channel : outputs)
                                     std::fill(channel, channel + count, 0.0F);
                                 samples += count;
                             });
    device.start();
    while (samples < 1000) std::this_thread::yield();
    device.stop();
    std::printf("%d samples or more\n", 1000);
}
