#include "audio/spatial/embedded_sofa_reader.h"

#include "process/embedded_file.h"

AULA_EMBEDDED_PROGRAM(embedded_sofa_reader, AULA_PROGRAM)
