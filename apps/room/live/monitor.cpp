#include "apps/room/live/monitor.h"

#include <array>
#include <chrono>
#include <exception>
#include <utility>

namespace aula {

namespace {

/// Far less than the capacity of the mixer's ring.
constexpr std::chrono::milliseconds kInterval{50};

}  // namespace

Monitor::Monitor(LiveMixer& mixer, double sample_rate_hz)
    : mixer_(&mixer),
      rate_hz_(sample_rate_hz),
      meter_(std::in_place, sample_rate_hz, mixer.channels()) {}

Monitor::~Monitor() {
    {
        const std::lock_guard lock(work_);
        stop_ = true;
    }
    stopping_.notify_all();
    if (thread_.joinable()) thread_.join();
    mixer_->listen(false);
    stop_recording();
}

void Monitor::start() {
    if (thread_.joinable()) return;
    {
        const std::lock_guard lock(work_);
        mixer_->listen(listens_ = true);
    }
    thread_ = std::thread([this] { run(); });
}

void Monitor::run() {
    std::unique_lock lock(work_);
    while (!stopping_.wait_for(lock, kInterval, [this] { return stop_; })) take_in();
}

/// Reads the output since the last call.
void Monitor::take_in() {
    std::array<float, 4096> samples;
    const std::size_t whole = samples.size() - samples.size() % mixer_->channels();
    for (;;) {
        const std::size_t count = mixer_->output_ring().read(std::span(samples).first(whole));
        if (count == 0) break;
        const std::span<const float> output(samples.data(), count);
        {
            const std::lock_guard lock(mutex_);
            meter_->add(output);
        }
        if (writer_) write(output);
    }
    if (!writer_) return;
    const auto lost = static_cast<double>(mixer_->lost_samples() - lost_before_);
    const std::lock_guard lock(mutex_);
    status_.lost_s = lost / rate_hz_;
}

void Monitor::write(std::span<const float> output) {
    std::string error;
    try {
        writer_->write(output);
    } catch (const std::exception& thrown) {
        error = thrown.what();
        writer_.reset();
    }
    const std::lock_guard lock(mutex_);
    if (writer_) {
        status_.recorded_s += static_cast<double>(output.size() / mixer_->channels()) / rate_hz_;
        return;
    }
    status_.recording = false;
    status_.error = error;
}

void Monitor::record(const std::filesystem::path& file) {
    stop_recording();
    start();
    const std::lock_guard work(work_);
    auto writer =
        std::make_unique<WavWriter>(file, rate_hz_, mixer_->channels(), SampleFormat::float32);
    take_in();
    writer_ = std::move(writer);
    lost_before_ = mixer_->lost_samples();
    const std::lock_guard lock(mutex_);
    status_ = {};
    status_.recording = true;
}

void Monitor::stop_recording() {
    const std::lock_guard work(work_);
    end_recording("");
}

/// Writes what has been played, and commits the file. `error`: why the recording ends early, if it
/// does. `work_` is locked.
void Monitor::end_recording(std::string error) {
    take_in();
    if (!writer_) return;
    try {
        writer_->commit();
    } catch (const std::exception& thrown) {
        error = thrown.what();
    }
    writer_.reset();
    const std::lock_guard lock(mutex_);
    status_.recording = false;
    status_.error = error;
}

void Monitor::follow(LiveMixer& mixer, double sample_rate_hz) {
    const std::lock_guard work(work_);
    end_recording("the recording ends: the sample rate of the output device has changed");
    mixer_->listen(false);
    mixer_ = &mixer;
    mixer_->listen(listens_);
    rate_hz_ = sample_rate_hz;
    const std::lock_guard lock(mutex_);
    meter_.emplace(sample_rate_hz, mixer.channels());
}

MonitorStatus Monitor::status() {
    const std::lock_guard lock(mutex_);
    status_.loudness = meter_->read();
    return status_;
}

}  // namespace aula
