#pragma once

#include <utility>

#include "aula/audio/realtime.h"

namespace aula {

#if defined(__clang__) && __clang_major__ >= 20
#pragma clang diagnostic push
#pragma clang diagnostic ignored "-Wfunction-effects"
#endif

/// Calls `call()`, which does not block although the compiler cannot know it: it calls a function
/// of the system, a library or a host, or a std::function. A comment beside each use says why it
/// does not block. The only exception from the compiler's check of AULA_NONBLOCKING.
template <typename Call>
decltype(auto) assume_nonblocking(Call&& call) noexcept AULA_NONBLOCKING {
    return std::forward<Call>(call)();
}

#if defined(__clang__) && __clang_major__ >= 20
#pragma clang diagnostic pop
#endif

}  // namespace aula
