#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "tests/support/jack_server.h"
#include "tests/support/temporary_folder.h"

namespace aula::test {

/// A PulseAudio server of this process's own with a null sink of two channels at 48 kHz that runs
/// in real time; what this process opens while it is alive finds this server and no JACK. running()
/// is false where none can run.
class PulseServer {
 public:
    PulseServer();
    ~PulseServer();
    PulseServer(const PulseServer&) = delete;
    PulseServer& operator=(const PulseServer&) = delete;

    bool running() const { return running_; }

    /// Ends the server, starts it again.
    void kill();
    void restart();

    /// Records what would be heard until the process ends.
    std::unique_ptr<ChildProcess> record(const std::filesystem::path& wav_file) const;

 private:
    TemporaryFolder folder_;
    std::string socket_;
    std::unique_ptr<ChildProcess> server_;
    bool running_ = false;
};

}  // namespace aula::test
