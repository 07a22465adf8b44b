#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "audio/device/output.h"

namespace aula {

namespace {

/// Requests samples in real time and discards them.
class SilentOutput final : public Output {
 public:
    explicit SilentOutput(const OutputSettings& settings) : settings_(settings) {
        for (std::size_t c = 0; c < settings.channels; ++c)
            channels_.emplace_back(static_cast<std::size_t>(settings.block));
        for (auto& channel : channels_) pointers_.push_back(channel.data());
    }
    ~SilentOutput() override {
        stop_ = true;
        if (thread_.joinable()) thread_.join();
    }

    void start() override {
        settings_.meter->touch();
        thread_ = std::thread([this] { run(); });
    }
    bool alive() const override { return true; }
    double latency_s() const override { return 0; }

 private:
    using Clock = std::chrono::steady_clock;

    void run() {
        const auto block = std::chrono::duration_cast<Clock::duration>(
            std::chrono::duration<double>(settings_.block / settings_.sample_rate_hz));
        Clock::time_point next = Clock::now();
        while (!stop_) {
            fill();
            // After a delay, missed blocks are not requested.
            next = std::max(next + block, Clock::now());
            std::this_thread::sleep_until(next);
        }
    }

    /// [audio thread, wait-free]
    void fill() noexcept AULA_NONBLOCKING {
        const FlushDenormals flush;
        settings_.meter->begin(false);
        settings_.call(pointers_, settings_.block);
        settings_.meter->end(settings_.block);
    }

    OutputSettings settings_;
    std::vector<std::vector<float>> channels_;
    std::vector<float*> pointers_;
    std::atomic<bool> stop_{false};
    std::thread thread_;
};

}  // namespace

DeviceInfo silent_output() {
    constexpr int kChannels = 16;
    DeviceInfo device;
    device.name = AudioDevice::kNone;
    device.host_api = "silence";
    device.output_channels = kChannels;
    return device;
}

std::unique_ptr<Output> open_silent_output(const OutputSettings& settings) {
    return std::make_unique<SilentOutput>(settings);
}

}  // namespace aula
