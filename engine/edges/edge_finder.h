#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/edges/diffraction_edge.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// Finds the diffracting edges of triangles that need not form a closed or connected mesh. Sides of
/// triangles are compared by lines instead of by vertices: sides within 1 mm of a line belong to
/// it, whatever their ends. Along a line, the faces that meet in each interval divide the space
/// around it into sectors. A sector above 181 degrees is the open angle of a wedge. Walls that are
/// modelled from both sides, or less than 1 mm thick, are single faces.
///
/// The edges are at least 0.25 m long, or 0.1 m while they are fewer than 2000, in the order of
/// their start points. Triangles within 0.3 m have none. The time is proportional to the number of
/// triangles.
std::vector<DiffractionEdge> find_edges(const RayScene& scene,
                                        std::span<const std::uint32_t> triangles);

}  // namespace aula
