#include "engine/scene/embedded_directivity_reader.h"

#include "process/embedded_file.h"

AULA_EMBEDDED_FILE(embedded_directivity_reader, AULA_PROGRAM)
