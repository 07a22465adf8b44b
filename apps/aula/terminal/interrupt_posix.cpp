#include "apps/aula/terminal/interrupt.h"

#include <fcntl.h>
#include <pthread.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <ctime>
#include <initializer_list>
#include <thread>

#include "audio/file/part_file.h"

namespace aula {

namespace {

/// Time for an orderly end. A fade-out and the end of a recording take far less.
constexpr timespec kOrderlyEnd{.tv_sec = 0, .tv_nsec = 800'000'000};

std::atomic<int> first_signal = 0;

void open_standard_descriptors() {
    for (int descriptor = STDIN_FILENO; descriptor <= STDERR_FILENO; ++descriptor) {
        if (fcntl(descriptor, F_GETFD) >= 0 || errno != EBADF) continue;
        // open() returns the lowest free descriptor, which is this one. Output to a closed
        // standard output is lost: writing it must fail.
        const int mode = descriptor == STDOUT_FILENO ? O_RDONLY : O_RDWR;
        if (open("/dev/null", mode) != descriptor) _exit(1);
    }
}

/// Records the first signal. Ends the process after kOrderlyEnd or at a second signal.
[[noreturn]] void handle_signals(const sigset_t& signals) {
    int signal = 0;
    while (sigwait(&signals, &signal) != 0) {
    }
    first_signal = signal;
    sigtimedwait(&signals, nullptr, &kOrderlyEnd);
    PartFile::abandon_all();
    _exit(128 + signal);
}

}  // namespace

void set_up_process() {
    open_standard_descriptors();
    for (const int signal : {SIGPIPE, SIGXFSZ}) std::signal(signal, SIG_IGN);
    sigset_t signals;
    sigemptyset(&signals);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGXCPU}) sigaddset(&signals, signal);
    // Blocked in this thread and in all later ones. One thread waits for the signals: unlike a
    // signal handler it may call any function.
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    std::thread(handle_signals, signals).detach();
}

int interrupt_signal() { return first_signal; }

std::vector<std::string> command_line(int count, char** words) { return {words, words + count}; }

}  // namespace aula
