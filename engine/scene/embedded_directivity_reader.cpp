#include "engine/scene/embedded_directivity_reader.h"

#include "process/embedded_program.h"

AULA_EMBEDDED_PROGRAM(embedded_directivity_reader, AULA_PROGRAM)
