#pragma once

#include <cstddef>
#include <span>

/// Defines a declared function of this name that returns the bytes of a file, which become part of
/// the library.
#define AULA_EMBEDDED_FILE(name, file)                                             \
    asm(".pushsection .rodata\n"                                                   \
        ".global aula_" #name                                                      \
        "_begin\n"                                                                 \
        "aula_" #name                                                              \
        "_begin:\n"                                                                \
        ".incbin \"" file                                                          \
        "\"\n"                                                                     \
        ".global aula_" #name                                                      \
        "_end\n"                                                                   \
        "aula_" #name                                                              \
        "_end:\n"                                                                  \
        ".popsection\n");                                                          \
    extern "C" const std::byte aula_##name##_begin[];                              \
    extern "C" const std::byte aula_##name##_end[];                                \
    decltype(aula::name()) aula::name() {                                          \
        return std::span<const std::byte>(aula_##name##_begin, aula_##name##_end); \
    }
