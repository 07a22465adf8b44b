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

/// The time that diffraction adds to loading: of the geometry at rest in as many copies side by
/// side as have at least 100,000 triangles.
std::vector<Row> measure_edge_search(const Subject& subject, const Settings& settings);

const std::vector<Column>& edge_search_columns();

/// A level of a game, with y up: the floors of a mesh file with a source and a listener.
Subject level_of(const std::filesystem::path& mesh_file, const Settings& settings);

}  // namespace aula::bench
