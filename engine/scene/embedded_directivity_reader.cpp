#include "engine/scene/embedded_directivity_reader.h"

#include "aula/exception.h"
#include "process/embedded_file.h"

#if defined(AULA_PROGRAM)
AULA_EMBEDDED_PROGRAM(embedded_directivity_reader, AULA_PROGRAM)
#else
aula::ContainedProgram aula::embedded_directivity_reader() {
    throw InputError(
        "needs HDF5 to be read, which Aula has not on this system; expected a directivity as a "
        "table in JSON");
}
#endif
