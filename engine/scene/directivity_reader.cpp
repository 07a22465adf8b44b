// A program that reads a SOFA file of directivities (FreeFieldDirectivityTF) from standard input
// and writes a DirectivityAnswer to standard output. It is embedded in the library and run by
// read_sofa_directivity().

#include "engine/scene/directivity_hdf5.h"
#include "process/contained_program.h"

int main() {
    using namespace aula;
    limit_resources();
    const DirectivityAnswer answer = read_hdf5_directivity("/proc/self/fd/0", [] {
        const rlimit none{0, 0};
        setrlimit(RLIMIT_NOFILE, &none);
    });
    const bool written = write(answer.header) && write(answer.coordinates) &&
                         write(answer.frequencies_hz) && write(answer.energies);
    return written && std::fflush(stdout) == 0 ? 0 : 1;
}
