#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "aula/engine/scene.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// Whether two scenes are equal except for materials, sources, listener and settings.
bool same_geometry(const Scene& a, const Scene& b);

/// The triangles of the same surface as a given one, by their index over all objects: of the same
/// object, in the same plane and connected over shared corners. `rays` belongs to the scene.
std::vector<std::uint32_t> surface_of(const RayScene& rays, std::uint32_t triangle);

/// All triangles with the material of a given one.
std::vector<std::uint32_t> triangles_like(const Scene& scene, std::uint32_t triangle);

/// The material of a triangle.
const Material& material_of(const Scene& scene, std::uint32_t triangle);

/// A copy of the scene in which the given triangles have a material. The material is added if the
/// scene does not have it. If the scene has a different one of the same name, the new one gets a
/// number.
Scene with_material(const Scene& scene, const std::vector<std::uint32_t>& triangles,
                    const Material& material);

/// A copy in which one material is replaced by another, of the scene or of those that ship with
/// Aula; empty if either name is unknown.
std::optional<Scene> with_material_replaced(const Scene& scene, const std::string& from,
                                            const std::string& to);

}  // namespace aula
