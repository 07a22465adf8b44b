#include "tests/support/pulse_server.h"

#include <chrono>
#include <cstdlib>
#include <thread>

namespace aula::test {

PulseServer::PulseServer(bool rewinds) : socket_(folder_.path() / "native"), rewinds_(rewinds) {
    const std::string folder = folder_.path();
    for (const char* name : {"XDG_RUNTIME_DIR", "PULSE_RUNTIME_PATH", "HOME"}) {
        setenv(name, folder.c_str(), 1);
    }
    setenv("PULSE_SERVER", ("unix:" + socket_).c_str(), 1);
    setenv("JACK_DEFAULT_SERVER", "aula-test-no-such-server", 1);
    setenv("JACK_NO_START_SERVER", "1", 1);
    restart();
}

PulseServer::~PulseServer() {
    server_.reset();
    unsetenv("PULSE_SERVER");
    unsetenv("JACK_DEFAULT_SERVER");
}

void PulseServer::kill() { server_.reset(); }

void PulseServer::restart() {
    server_ = std::make_unique<ChildProcess>(std::vector<std::string>{
        "pulseaudio", "-n", "--daemonize=no", "--use-pid-file=no", "--exit-idle-time=-1", "-L",
        std::string("module-null-sink sink_name=out rate=48000 channels=2 norewinds=") +
            (rewinds_ ? "0" : "1"),
        "-L", "module-native-protocol-unix socket=" + socket_ + " auth-anonymous=1"});
    running_ = false;
    for (int turn = 0; turn < 50 && !running_; ++turn) {
        running_ = ChildProcess({"pactl", "info"}).wait() == 0;
        if (!running_) std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
}

std::unique_ptr<ChildProcess> PulseServer::record(const std::filesystem::path& wav_file) const {
    return std::make_unique<ChildProcess>(
        std::vector<std::string>{"parec", "-d", "out.monitor", "--format=float32le", "--rate=48000",
                                 "--channels=2", "--file-format=wav", wav_file.string()});
}

}  // namespace aula::test
