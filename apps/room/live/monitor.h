#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>

#include "apps/room/live/live_mixer.h"
#include "audio/dsp/loudness.h"
#include "aula/audio/sound_file.h"

namespace aula {

/// The loudness and the recording of the output.
struct MonitorStatus {
    Loudness loudness;
    bool recording = false;
    double recorded_s = 0;  ///< of the present or the last recording
    double lost_s = 0;      ///< lost because the disk was too slow
    std::string error;      ///< why the last recording ended early; empty if it did not
};

/// Reads the output of a mixer on a separate thread, from start() on: measures its loudness and, on
/// request, records it to a file (32-bit float). The mixer must live until the end or until
/// follow().
class Monitor {
 public:
    Monitor(LiveMixer& mixer, double sample_rate_hz);
    ~Monitor();
    Monitor(const Monitor&) = delete;
    Monitor& operator=(const Monitor&) = delete;

    void start();

    /// Reads another mixer, of another sample rate, from now on, and measures anew. Ends a
    /// recording, with an error in the status. [any thread]
    void follow(LiveMixer& mixer, double sample_rate_hz);

    /// Begins a recording. Throws InputError if the file cannot be written.
    void record(const std::filesystem::path& file);

    /// Ends the recording, if there is one, and commits the file.
    void stop_recording();

    /// The true peak is that since the last call. Does not wait for the disk.
    MonitorStatus status();

 private:
    void run();
    void take_in();
    void write(std::span<const float> output);
    void end_recording(std::string error);

    std::mutex work_;  ///< held while reading and writing; protects the following members
    LiveMixer* mixer_;
    double rate_hz_;
    bool listens_ = false;
    std::condition_variable stopping_;
    bool stop_ = false;
    std::unique_ptr<WavWriter> writer_;
    std::int64_t lost_before_ = 0;  ///< samples that the mixer had lost when the recording began

    std::mutex mutex_;  ///< protects the following members; locked after `work_`
    std::optional<LoudnessMeter> meter_;
    MonitorStatus status_;

    std::thread thread_;
};

}  // namespace aula
