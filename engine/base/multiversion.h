#pragma once

// Compiles a hot function for several instruction sets, including a portable one. The loader
// selects the best one that the CPU supports. GCC compiles calls of the function as if it threw
// nothing: an exception ends the program if the caller has destructors to call.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define AULA_MULTIVERSION \
    __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define AULA_MULTIVERSION
#endif
