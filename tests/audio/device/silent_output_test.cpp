#include <algorithm>
#include <catch2/catch.hpp>
#include <future>
#include <span>
#include <utility>

#include "aula/devices/device.h"

using namespace aula;

TEST_CASE("The silent device requests blocks continuously and has no underruns") {
    constexpr int kBlock = 64;
    constexpr int kCalls = 20;
    std::promise<void> enough;
    int calls = 0;
    bool odd = false;
    AudioDevice device(AudioDevice::kNone, 48000, 2, kBlock,
                       [&](std::span<float* const> outputs, int samples) {
                           odd = odd || outputs.size() != 2 || samples != kBlock;
                           if (++calls == kCalls) enough.set_value();
                       });
    CHECK(device.info().name == "none");
    device.start();
    enough.get_future().wait();
    CHECK(device.active());
    device.stop();
    CHECK_FALSE(device.active());
    CHECK(calls >= kCalls);
    CHECK_FALSE(odd);
    CHECK(device.meter().underruns() == 0);
    CHECK(device.meter().mean_load() > 0);
    CHECK(device.reconnects() == 0);
    CHECK(device.info().latency_s == 0);
}

TEST_CASE("Each channel of the silent device has its own memory for a block") {
    constexpr int kBlock = 32;
    std::promise<bool> distinct;
    bool called = false;
    AudioDevice device(AudioDevice::kNone, 48000, 3, kBlock,
                       [&](std::span<float* const> outputs, int samples) {
                           if (std::exchange(called, true)) return;
                           float value = 0;
                           for (float* const channel : outputs)
                               std::fill_n(channel, samples, ++value);
                           value = 0;
                           bool kept = true;
                           for (const float* const channel : outputs) {
                               ++value;
                               kept = kept && channel[0] == value && channel[samples - 1] == value;
                           }
                           distinct.set_value(kept);
                       });
    device.start();
    CHECK(distinct.get_future().get());
    device.stop();
}
