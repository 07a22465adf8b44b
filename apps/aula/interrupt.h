#pragma once

namespace aula {

/// From here on Ctrl-C, SIGTERM and SIGHUP are only noted, so that the program can end in order; a
/// second one ends it at once, and what it was writing is removed. Before any thread begins.
void note_interrupts();

/// The signal that arrived, or 0. [any thread]
int interrupt_signal();

}  // namespace aula
