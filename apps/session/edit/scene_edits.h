#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/rays/ray_scene.h"
#include "engine/scene/scene.h"

namespace aula {

/// Whether two scenes are alike in all but materials, sources, listener and settings.
bool same_geometry(const Scene& a, const Scene& b);

/// The triangles, by their index over all objects, that are one surface with a given one: of the
/// same object, in the same plane, connected with it over shared corners. `rays` is of the scene.
std::vector<std::uint32_t> surface_of(const RayScene& rays, std::uint32_t triangle);

/// All triangles of the material that a given one has.
std::vector<std::uint32_t> triangles_like(const Scene& scene, std::uint32_t triangle);

/// The material of a triangle.
const Material& material_of(const Scene& scene, std::uint32_t triangle);

/// A copy of the scene in which triangles have a material, which enters the scene if it is not
/// among its own. One of the same name and other values is left alone, and the new one gets a
/// number.
Scene with_material(const Scene& scene, const std::vector<std::uint32_t>& triangles,
                    const Material& material);

/// A copy in which all that had one material has another, of the scene or of those that ship with
/// Aula; empty if either name is not known.
std::optional<Scene> with_material_replaced(const Scene& scene, const std::string& from,
                                            const std::string& to);

}  // namespace aula
