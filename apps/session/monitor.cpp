#include "apps/session/monitor.h"

#include <array>
#include <chrono>
#include <exception>

namespace aula {

namespace {

/// Far less than what the mixer keeps.
constexpr std::chrono::milliseconds kInterval{50};

}  // namespace

Monitor::Monitor(LiveMixer& mixer, double sample_rate_hz)
    : mixer_(mixer), rate_hz_(sample_rate_hz), meter_(sample_rate_hz, mixer.channels()) {}

Monitor::~Monitor() {
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
    }
    stopping_.notify_all();
    if (thread_.joinable()) thread_.join();
    mixer_.listen(false);
    stop_recording();
}

void Monitor::start() {
    if (thread_.joinable()) return;
    mixer_.listen(true);
    thread_ = std::thread([this] { run(); });
}

void Monitor::run() {
    std::unique_lock lock(mutex_);
    while (!stopping_.wait_for(lock, kInterval, [this] { return stop_; })) take_in();
}

/// Reads what has been heard since the last time. The mutex is held.
void Monitor::take_in() {
    std::array<float, 4096> samples;
    const std::size_t whole = samples.size() - samples.size() % mixer_.channels();
    for (;;) {
        const std::size_t count = mixer_.heard().read(std::span(samples).first(whole));
        if (count == 0) return;
        const std::span<const float> heard(samples.data(), count);
        meter_.add(heard);
        if (!writer_) continue;
        try {
            writer_->write(heard);
            recorded_samples_ += count / mixer_.channels();
        } catch (const std::exception& thrown) {
            error_ = thrown.what();
            writer_.reset();
        }
    }
}

void Monitor::record(const std::filesystem::path& file) {
    stop_recording();
    start();
    auto writer =
        std::make_unique<WavWriter>(file, rate_hz_, mixer_.channels(), SampleFormat::float32);
    const std::lock_guard lock(mutex_);
    take_in();
    writer_ = std::move(writer);
    recorded_samples_ = 0;
    error_.clear();
}

void Monitor::stop_recording() {
    const std::lock_guard lock(mutex_);
    take_in();
    if (!writer_) return;
    try {
        writer_->commit();
    } catch (const std::exception& thrown) {
        error_ = thrown.what();
    }
    writer_.reset();
}

MonitorStatus Monitor::status() {
    const std::lock_guard lock(mutex_);
    return {meter_.read(), writer_ != nullptr, static_cast<double>(recorded_samples_) / rate_hz_,
            error_};
}

}  // namespace aula
