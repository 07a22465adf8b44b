#pragma once

#include <filesystem>

#include "apps/aula/arguments/arguments.h"

namespace aula {

/// The file of a source's impulse response: `file` for a single source, else OUT-NAME.wav, with
/// characters outside [A-Za-z0-9._-] replaced by '_'.
std::filesystem::path response_file(const std::filesystem::path& file, const Scene& scene,
                                    std::size_t source);

/// The files of a map: a picture and a table of each parameter of a source.
struct MapFiles {
    std::filesystem::path table, picture;
};
MapFiles map_files(const Arguments& arguments, const Scene& scene, std::size_t source,
                   std::size_t parameter);

/// Throws InputError if an output file is also an input file, or if two outputs are the same file,
/// or if a folder has the name of a file of a map, or if a write-protected file would be replaced.
/// Names and links of one file count as the same.
void check_outputs(const Arguments& arguments, const Scene& scene);

}  // namespace aula
