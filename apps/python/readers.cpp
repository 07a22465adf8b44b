#include <dlfcn.h>

#include "audio/file/embedded_sound_reader.h"
#include "audio/spatial/embedded_sofa_reader.h"
#include "aula/exception.h"
#include "engine/scene/embedded_directivity_reader.h"

// The programs that read files are files beside the module, not embedded in it: auditwheel finds
// the libraries that they need, as it finds those of the module. The linker takes these functions,
// which are defined first, instead of those of the libraries.

namespace aula {

namespace {

/// In the folder of the module.
std::filesystem::path program(const char* name) {
    Dl_info module{};
    if (dladdr(name, &module) == 0)
        throw Failure(std::string(name) + ": the folder of the module aula is unknown");
    return std::filesystem::path(module.dli_fname).replace_filename(name);
}

}  // namespace

ContainedProgram embedded_directivity_reader() { return program("aula_directivity_reader"); }
ContainedProgram embedded_sound_reader() { return program("aula_sound_reader"); }
ContainedProgram embedded_sofa_reader() { return program("aula_sofa_reader"); }

}  // namespace aula
