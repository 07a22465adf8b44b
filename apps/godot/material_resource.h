#pragma once

#include <memory>
#include <string>
#include <vector>

#include "apps/godot/bind/class_library.h"

namespace aula::godot {

/// Names of the materials that ship with Aula, with commas between them.
extern const char* const kPresetNames;

/// Whether a material ships with Aula.
bool is_preset(const std::string& name);

/// AulaMaterial: a material that ships, or values of its own for 8 octaves.
class MaterialResource final : public Instance {
 public:
    using Instance::Instance;

    /// The name in a scene.
    std::string name() const;

    std::string preset = "plaster";  ///< empty: the values below
    std::vector<float> absorption, scattering, sound_reduction_db;
};

std::unique_ptr<ClassEntry> register_material();

/// A property that is an AulaMaterial.
ValueInfo material_property(const char* name);

}  // namespace aula::godot
