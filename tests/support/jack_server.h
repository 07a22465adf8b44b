#pragma once

#include <sys/types.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/program.h"

namespace aula::test {

/// A child process without input or output, ended by its id.
class ChildProcess {
 public:
    explicit ChildProcess(const std::vector<std::string>& command);
    ~ChildProcess();
    ChildProcess(const ChildProcess&) = delete;
    ChildProcess& operator=(const ChildProcess&) = delete;

    /// Waits for its end; the exit status, or -1 if it was killed or not started.
    int wait();

 private:
    pid_t id_ = -1;
};

/// A JACK server of this process's own with a dummy device of two channels at 48 kHz that runs in
/// real time; what this process opens while it is alive finds this server. running() is false where
/// none can run.
class JackServer {
 public:
    explicit JackServer(int period_samples);
    ~JackServer();
    JackServer(const JackServer&) = delete;
    JackServer& operator=(const JackServer&) = delete;

    bool running() const { return running_; }

 private:
    std::string name_;
    std::unique_ptr<ChildProcess> server_;
    bool running_ = false;
};

/// Records for some seconds, as float, what goes to the server's outputs.
class JackRecording {
 public:
    JackRecording(const std::filesystem::path& wav_file, int seconds);

    /// False where nothing can be recorded.
    bool running() const { return running_; }

    /// Waits for the end. Whether the server was in time, and the recorder, all the while.
    bool in_time();

 private:
    Program program_;
    bool running_ = false;
};

}  // namespace aula::test
