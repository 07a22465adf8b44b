#include "apps/aula/interrupt.h"

#include <csignal>
#include <initializer_list>

namespace aula {

namespace {

// A signal handler has nowhere else to leave its news.
volatile std::sig_atomic_t noted_signal = 0;

void note(int signal) { noted_signal = signal; }

}  // namespace

void note_interrupts() {
    struct sigaction action {};
    action.sa_handler = note;
    sigemptyset(&action.sa_mask);
    // What takes long is not asked whether it should end: the second signal ends the program.
    action.sa_flags = SA_RESTART | static_cast<int>(SA_RESETHAND);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaction(signal, &action, nullptr);
}

int interrupt_signal() { return noted_signal; }

}  // namespace aula
