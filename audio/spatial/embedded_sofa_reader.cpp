#include "audio/spatial/embedded_sofa_reader.h"

// The bytes of the program, from the file made by the build.
asm(".pushsection .rodata\n"
    ".global aula_sofa_reader_begin\n"
    "aula_sofa_reader_begin:\n"
    ".incbin \"" AULA_SOFA_READER
    "\"\n"
    ".global aula_sofa_reader_end\n"
    "aula_sofa_reader_end:\n"
    ".popsection\n");

extern "C" const std::byte aula_sofa_reader_begin[];
extern "C" const std::byte aula_sofa_reader_end[];

namespace aula {

std::span<const std::byte> embedded_sofa_reader() {
    return {aula_sofa_reader_begin, aula_sofa_reader_end};
}

}  // namespace aula
