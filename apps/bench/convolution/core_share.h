#pragma once

#include <optional>

namespace aula::bench {

/// Additions that this thread's core gets through in a clock cycle, tried for 0.1 ms in registers
/// alone: as many as it has units for, or fewer while its other hardware thread works, be it
/// another system's. Code of many instructions then is slower, code that waits for one result after
/// the other hardly. None where it is not known how to tell.
std::optional<double> additions_per_cycle();

}  // namespace aula::bench
