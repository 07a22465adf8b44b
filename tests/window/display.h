#pragma once

#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <string>
#include <thread>

#include "tests/support/jack_server.h"
#include "tests/support/program.h"

namespace aula::test {

/// A private X display in memory.
class Display {
 public:
    explicit Display(const std::string& size = "1600x1200")
        : server_({"Xvfb", name_, "-screen", "0", size + "x24", "+extension", "GLX", "-nolisten",
                   "tcp"}) {
        setenv("DISPLAY", name_.c_str(), 1);
        for (int turn = 0; turn < 50 && !running_; ++turn) {
            running_ =
                run_program({"sh", "-c", "test -S /tmp/.X11-unix/X" + name_.substr(1)}).status == 0;
            if (!running_) std::this_thread::sleep_for(std::chrono::milliseconds(100));
        }
    }
    ~Display() { unsetenv("DISPLAY"); }
    bool running() const { return running_; }

 private:
    std::string name_ = ":" + std::to_string(200 + getpid() % 700);
    ChildProcess server_;
    bool running_ = false;
};

}  // namespace aula::test
