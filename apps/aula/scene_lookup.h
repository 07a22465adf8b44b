#pragma once

#include <filesystem>
#include <vector>

namespace aula {

/// The folders with the scenes that ship: beside the installed program and in the source tree from
/// which the running program was built. Only those that exist.
std::vector<std::filesystem::path> scene_folders();

/// The file of a SCENE of the command line. A name without a slash that is no file is looked up in
/// the folders, also with the extension .json. Throws InputError, with the folders, if it is in
/// none.
std::filesystem::path find_scene(const std::filesystem::path& name,
                                 const std::vector<std::filesystem::path>& folders);

}  // namespace aula
