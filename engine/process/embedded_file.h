#pragma once

#include <cstddef>
#include <span>

#include "process/child_process.h"

#if defined(_WIN32)
#define AULA_READ_ONLY_SECTION ".section .rdata,\"dr\"\n"
#define AULA_SECTION_BEFORE ".text\n"
#elif defined(__APPLE__)
#define AULA_READ_ONLY_SECTION ".section __TEXT,__const\n"
#define AULA_SECTION_BEFORE ".byte 0\n.text\n"  // the linker drops what is empty
#else
#define AULA_READ_ONLY_SECTION ".pushsection .rodata\n"
#define AULA_SECTION_BEFORE ".popsection\n"
#endif
#if defined(__APPLE__)
#define AULA_GLOBAL ".private_extern "
#define AULA_SYMBOL "_aula_"
#else
#define AULA_GLOBAL ".globl "
#define AULA_SYMBOL "aula_"
#endif

/// Defines a declared function of this name that returns the bytes of a file, which become part of
/// the library.
#define AULA_EMBEDDED_FILE(name, file)                                                    \
    asm(AULA_READ_ONLY_SECTION AULA_GLOBAL AULA_SYMBOL #name                              \
        "_begin\n" AULA_SYMBOL #name                                                      \
        "_begin:\n"                                                                       \
        ".incbin \"" file "\"\n" AULA_GLOBAL AULA_SYMBOL #name "_end\n" AULA_SYMBOL #name \
        "_end:\n" AULA_SECTION_BEFORE);                                                   \
    extern "C" const std::byte aula_##name##_begin[];                                     \
    extern "C" const std::byte aula_##name##_end[];                                       \
    decltype(aula::name()) aula::name() {                                                 \
        return std::span<const std::byte>(aula_##name##_begin, aula_##name##_end);        \
    }

/// The same for a program of a ContainedProcess. Windows runs no bytes: there it is a file beside
/// the program or the library.
#if defined(_WIN32)
#define AULA_EMBEDDED_PROGRAM(name, file)                                   \
    decltype(aula::name()) aula::name() {                                   \
        return aula::beside_binary(std::filesystem::path(file).filename()); \
    }
#else
#define AULA_EMBEDDED_PROGRAM(name, file) AULA_EMBEDDED_FILE(name, file)
#endif
