#pragma once

#include "apps/aula/arguments.h"
#include "engine/scene/scene_file.h"

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

/// Reads a scene file. Warnings go to standard error, here and below. Throws Error.
LoadedScene read_scene_file(const std::filesystem::path& file, const Arguments& arguments);

/// Applies the command line to a scene. Throws Error.
void change_scene(Scene& scene, const Arguments& arguments);

/// Both, for the scene of the command line.
Scene read_scene(const Arguments& arguments);

/// "aula: warning: ..." on standard error, unless quiet.
void warn(const std::vector<std::string>& warnings, bool quiet);

/// 128 and the number of the signal that arrived, as shells do.
int interrupted_status();

}  // namespace aula
