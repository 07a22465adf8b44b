#pragma once

// A header of the standard library defines __GLIBC__ where the C library is glibc.
#include <cstddef>

// Compiles a hot function for several instruction sets, including a portable one. The loader
// selects the best one that the CPU supports (ifunc); of the C libraries for x86-64 that GCC
// compiles for, glibc has such a loader; musl, MinGW and macOS have none and get the portable
// function. The loader selects before sanitizers are initialised. GCC compiles calls of the
// function as if it threw nothing: an exception ends the program if the caller has destructors to
// call.
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define AULA_MULTIVERSION \
    __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define AULA_MULTIVERSION
#endif
