#include "audio/file/embedded_sound_reader.h"

#include "process/embedded_file.h"

AULA_EMBEDDED_PROGRAM(embedded_sound_reader, AULA_PROGRAM)
