#include "tests/support/jack_server.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <thread>

namespace aula::test {

namespace {

int run(const std::vector<std::string>& command) { return ChildProcess(command).wait(); }

/// True if a port of that client appears within five seconds.
bool appears(const std::string& client) {
    for (int turn = 0; turn < 50; ++turn) {
        if (run({"sh", "-c", "jack_lsp 2>/dev/null | grep -q '^" + client + "'"}) == 0) return true;
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return false;
}

}  // namespace

ChildProcess::ChildProcess(const std::vector<std::string>& command) {
    std::vector<char*> arguments;
    for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
        posix_spawn_file_actions_addopen(&actions, descriptor, "/dev/null", O_RDWR, 0);
    }
    if (posix_spawnp(&id_, arguments[0], &actions, nullptr, arguments.data(), environ) != 0) {
        id_ = -1;
    }
    posix_spawn_file_actions_destroy(&actions);
}

ChildProcess::~ChildProcess() {
    if (id_ < 0) return;
    kill(id_, SIGTERM);
    wait();
}

int ChildProcess::wait() {
    if (id_ < 0) return -1;
    int status = 0;
    const bool ended = waitpid(id_, &status, 0) == id_;
    id_ = -1;
    return ended && WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

JackServer::JackServer(int period_samples, int inputs, int sample_rate_hz) {
    setenv("JACK_NO_START_SERVER", "1", 1);
    const bool has_priority = run({"chrt", "-f", "1", "true"}) == 0;
    // On a busy machine a server may not answer in time; another one has another name. Otherwise
    // the next server has the name of the last one, under which its clients wait for it.
    static int failures = 0;
    for (int attempt = 0; attempt < 3 && !running_; ++attempt) {
        server_.reset();
        const std::string name =
            "aula-test-" + std::to_string(getpid()) + "-" + std::to_string(failures);
        setenv("JACK_DEFAULT_SERVER", name.c_str(), 1);
        std::vector<std::string> command{"jackd"};
        if (has_priority) {
            command.insert(command.end(), {"-R", "-P", "60"});
        } else {
            command.push_back("-r");
        }
        command.insert(command.end(),
                       {"-n", name, "-d", "dummy", "-r", std::to_string(sample_rate_hz), "-p",
                        std::to_string(period_samples), "-C", std::to_string(inputs), "-P", "2"});
        server_ = std::make_unique<ChildProcess>(command);
        running_ = run({"jack_wait", "-s", name, "-w", "-t", "10"}) == 0;
        if (!running_) ++failures;
    }
}

JackServer::~JackServer() {
    server_.reset();
    unsetenv("JACK_DEFAULT_SERVER");
}

JackRecording::JackRecording(const std::filesystem::path& wav_file, int seconds)
    : program_({"jack_capture", "-d", std::to_string(seconds), "-c", "2", "--no-stdin", "-dc", "-f",
                "wav", "-b", "FLOAT", wav_file.string()}),
      running_(appears("jack_capture:input2")) {}

bool JackRecording::in_time() { return program_.wait().out.find("x-runs") == std::string::npos; }

}  // namespace aula::test
