#pragma once

#include <filesystem>
#include <vector>

#include "apps/bench/base/settings.h"
#include "apps/bench/base/table.h"

namespace aula::bench {

/// The part of diffraction in the time of frames of `patch`, with one source and with eight, while
/// the listener walks: on its path, else to and fro towards the first source.
std::vector<Row> measure_diffraction(const Subject& subject, const Settings& settings);

const std::vector<Column>& diffraction_columns();

/// A level of a game, with y up: the floors of a mesh file with a source and a listener.
Subject level_of(const std::filesystem::path& mesh_file, const Settings& settings);

}  // namespace aula::bench
