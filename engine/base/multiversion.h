#pragma once

// Compiles a hot function for several instruction sets; the best one that the machine has is
// chosen when the program starts. The portable version stands beside them.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define AULA_MULTIVERSION \
    __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define AULA_MULTIVERSION
#endif
