// Windows has no functions to replace in the modules of a process: nothing is counted.

#include "tests/support/realtime_trap.h"

namespace aula::test {

RealtimeViolations& RealtimeViolations::operator+=(const RealtimeViolations&) { return *this; }

RealtimeTrap::RealtimeTrap() = default;
RealtimeTrap::~RealtimeTrap() = default;
RealtimeViolations RealtimeTrap::violations() const { return {}; }
bool RealtimeTrap::available() { return false; }

}  // namespace aula::test
