// A program that reads a SOFA file of directivities (FreeFieldDirectivityTF) from standard input
// and writes a DirectivityAnswer to standard output. It is embedded in the library and run by
// read_sofa_directivity().

#include <cstdlib>

#include "engine/scene/directivity_hdf5.h"
#include "process/contained_program.h"

int main() {
    using namespace aula;
    const DirectivityAnswer answer = read_hdf5_directivity(contain());
    const bool written = write(answer.header) && write(answer.coordinates) &&
                         write(answer.frequencies_hz) && write(answer.energies);
    std::_Exit(written ? 0 : 1);
}
