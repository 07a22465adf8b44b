#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "tests/support/jack_server.h"
#include "tests/support/temporary_folder.h"

namespace aula::test {

/// A private PulseAudio server with a null sink of two channels at 48 kHz in real time. Clients
/// that this process opens connect to it, and find no JACK server. running() is false if no server
/// can run here.
class PulseServer {
 public:
    /// `rewinds`: the sink has buffers of two seconds while it is idle, as sinks have by default.
    /// It then rewrites samples that are already recorded.
    explicit PulseServer(bool rewinds = false);
    ~PulseServer();
    PulseServer(const PulseServer&) = delete;
    PulseServer& operator=(const PulseServer&) = delete;

    bool running() const { return running_; }

    /// Ends and restarts the server.
    void kill();
    void restart();

    /// Records the sink's output until the returned process ends.
    std::unique_ptr<ChildProcess> record(const std::filesystem::path& wav_file) const;

 private:
    TemporaryFolder folder_;
    std::string socket_;
    bool rewinds_;
    std::unique_ptr<ChildProcess> server_;
    bool running_ = false;
};

}  // namespace aula::test
