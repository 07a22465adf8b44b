#include <catch2/catch.hpp>
#include <future>

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
}
