#include "apps/aula/interrupt.h"

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

/// Far more than a fade and the end of a recording take.
constexpr timespec kOrderlyEnd{.tv_sec = 0, .tv_nsec = 800'000'000};

std::atomic<int> noted_signal = 0;

void open_standard_descriptors() {
    for (int descriptor = STDIN_FILENO; descriptor <= STDERR_FILENO; ++descriptor) {
        if (fcntl(descriptor, F_GETFD) >= 0 || errno != EBADF) continue;
        // The lowest that is free is taken, which is this one.
        if (open("/dev/null", O_RDWR) != descriptor) _exit(1);
    }
}

/// Waits for a signal, then gives the program some time to end.
[[noreturn]] void end_when_told(const sigset_t& signals) {
    int signal = 0;
    while (sigwait(&signals, &signal) != 0) {
    }
    noted_signal = signal;
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
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals, signal);
    // Here and in all threads that begin from now on: what comes waits for this one, which may do
    // more than a signal handler.
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    std::thread(end_when_told, signals).detach();
}

int interrupt_signal() { return noted_signal; }

}  // namespace aula
