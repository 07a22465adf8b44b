#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <thread>

#include "apps/session/live/live_mixer.h"
#include "audio/dsp/loudness.h"
#include "aula/audio/sound_file.h"

namespace aula {

/// What is heard: its loudness, and a recording of it.
struct MonitorStatus {
    Loudness loudness;
    bool recording = false;
    double recorded_s = 0;  ///< of this recording, or the last
    double lost_s = 0;      ///< missing in it, as the disk was too slow
    std::string error;      ///< why the last recording ended early; empty if it did not
};

/// Listens to a mixer on a thread of its own, from start() on: measures loudness and, when asked
/// to, writes what is heard to a file (32-bit float). The mixer outlives it.
class Monitor {
 public:
    Monitor(LiveMixer& mixer, double sample_rate_hz);
    ~Monitor();
    Monitor(const Monitor&) = delete;
    Monitor& operator=(const Monitor&) = delete;

    void start();

    /// Begins a recording. Throws InputError if the file cannot be written.
    void record(const std::filesystem::path& file);

    /// Ends the recording, if there is one, and gives the file its name.
    void stop_recording();

    /// The true peak is that since the last call. Does not wait for the disk.
    MonitorStatus status();

 private:
    void run();
    void take_in();
    void write(std::span<const float> heard);

    LiveMixer& mixer_;
    double rate_hz_;

    std::mutex work_;  ///< held while reading and writing; of what follows
    std::condition_variable stopping_;
    bool stop_ = false;
    std::unique_ptr<WavWriter> writer_;
    std::int64_t lost_before_ = 0;  ///< samples that the mixer had lost when the recording began

    std::mutex mutex_;  ///< of what follows; taken after `work_`
    LoudnessMeter meter_;
    MonitorStatus status_;

    std::thread thread_;
};

}  // namespace aula
