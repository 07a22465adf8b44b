#pragma once

namespace aula {

/// From here on Ctrl-C and SIGTERM are only noted, so that the program can end in order.
void note_interrupts();

/// The signal that arrived, or 0. [any thread]
int interrupt_signal();

}  // namespace aula
