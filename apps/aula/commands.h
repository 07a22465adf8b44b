#pragma once

#include "apps/aula/arguments.h"

namespace aula {

// What the program does, one function a mode. Each returns the exit status; throws Error,
// AudioInputError or AudioFailure.

int list_devices();
int list_materials(const Arguments& arguments);
int show_info(const Arguments& arguments);
int check_scene(const Arguments& arguments);
int play(const Arguments& arguments);
int render(const Arguments& arguments);
int measure(const Arguments& arguments);

/// Reads the scene and applies the command line to it; warnings go to standard error.
Scene read_scene(const Arguments& arguments);

/// "aula: warning: ..." on standard error, unless quiet.
void warn(const std::vector<std::string>& warnings, bool quiet);

/// 128 and the number of the signal that arrived, as shells do.
int interrupted_status();

}  // namespace aula
