#pragma once

#include <sys/types.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/program.h"

namespace aula::test {

/// A child process without input or output. The destructor ends it.
class ChildProcess {
 public:
    explicit ChildProcess(const std::vector<std::string>& command);
    ~ChildProcess();
    ChildProcess(const ChildProcess&) = delete;
    ChildProcess& operator=(const ChildProcess&) = delete;

    /// Waits for its end. Returns the exit status, or -1 if a signal ended it or it did not start.
    int wait();

 private:
    pid_t id_ = -1;
};

/// A private JACK server with a dummy device of two outputs and `inputs` inputs, which are silent,
/// in real time. Clients that this process opens connect to it. running() is false if no
/// server can run here.
class JackServer {
 public:
    explicit JackServer(int period_samples, int inputs = 2, int sample_rate_hz = 48000);
    ~JackServer();
    JackServer(const JackServer&) = delete;
    JackServer& operator=(const JackServer&) = delete;

    bool running() const { return running_; }

 private:
    std::unique_ptr<ChildProcess> server_;
    bool running_ = false;
};

/// Records the server's outputs as float for some seconds.
class JackRecording {
 public:
    JackRecording(const std::filesystem::path& wav_file, int seconds);

    /// False if the recorder did not start.
    bool running() const { return running_; }

    /// Waits for the end. True if neither server nor recorder had an overrun.
    bool in_time();

 private:
    Program program_;
    bool running_ = false;
};

}  // namespace aula::test
