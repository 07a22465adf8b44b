#pragma once

namespace aula {

/// Sets up the process, before any thread begins:
/// * Ctrl-C, SIGTERM and SIGHUP are noted, so that the program can end in order. A program that has
///   not ended within 0.8 s, or gets a second signal, is ended: what it was writing is removed, the
///   exit status is 128 and the number of the first signal.
/// * A write to a closed pipe, or beyond the limit of file sizes, fails like any other.
/// * Descriptors 0 to 2 are open, so that no file of ours takes their places.
void set_up_process();

/// The signal that arrived, or 0. [any thread]
int interrupt_signal();

}  // namespace aula
