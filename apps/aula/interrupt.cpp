#include "apps/aula/interrupt.h"

#include <pthread.h>

#include <atomic>
#include <csignal>
#include <initializer_list>
#include <thread>

#include "audio/part_file.h"

namespace aula {

namespace {

std::atomic<int> noted_signal = 0;

int wait_for(const sigset_t& signals) {
    int signal = 0;
    while (sigwait(&signals, &signal) != 0) {
    }
    return signal;
}

}  // namespace

void note_interrupts() {
    sigset_t signals;
    sigemptyset(&signals);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals, signal);
    // Here and in all threads that begin from now on: what comes waits for this one, which may do
    // more than a signal handler.
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    std::thread([signals] {
        noted_signal = wait_for(signals);
        // What takes long is not asked whether it should end: the second signal ends the program.
        const int second = wait_for(signals);
        PartFile::abandon_all();
        std::signal(second, SIG_DFL);
        pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
        raise(second);
    }).detach();
}

int interrupt_signal() { return noted_signal; }

}  // namespace aula
