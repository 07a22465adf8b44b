#pragma once

#include "apps/aula/arguments/arguments.h"
#include "aula/engine/scene_file.h"

namespace aula {

// Commands of the program. Each returns the exit status, or throws InputError or Failure.

int list_devices();
int list_materials(const Arguments& arguments);
int show_info(const Arguments& arguments);
int check_scene(const Arguments& arguments);
int import_model(const Arguments& arguments);
int play(const Arguments& arguments);
int render(const Arguments& arguments);
int measure(const Arguments& arguments);
int dataset(const DatasetArguments& arguments);
int map_room(const Arguments& arguments);
int report_room(const Arguments& arguments);
int analyse(const Arguments& arguments);

/// Reads a scene file; prints its warnings to standard error. Throws InputError.
LoadedScene read_scene_file(const std::filesystem::path& file, const Arguments& arguments);

/// Applies the options of the command line to a scene; prints warnings to standard error. Throws
/// InputError.
void change_scene(Scene& scene, const Arguments& arguments);

/// Reads the scene of the command line, applies the options and checks the output files. Throws
/// InputError.
Scene read_scene(const Arguments& arguments);

/// Prints each warning as "aula: warning: ..." to standard error, unless quiet.
void warn(const std::vector<std::string>& warnings, bool quiet);

/// Exit status of an interrupted program: 128 + signal number.
int interrupted_status();

}  // namespace aula
