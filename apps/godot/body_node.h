#pragma once

#include <memory>

#include "apps/godot/bind/class_library.h"
#include "apps/godot/material_resource.h"

namespace aula::godot {

/// AulaBody3D: the meshes below it have its material, move with it, or are not part of the room.
class BodyNode final : public Instance {
 public:
    using Instance::Instance;

    /// Null: the material of the nearest body above it.
    const MaterialResource* material() const {
        return instance_of<MaterialResource>(material_value.to_object());
    }

    Value material_value;
    bool moving = false;
    bool audible = true;  ///< false: the meshes below it are left out
};

std::unique_ptr<ClassEntry> register_body();

}  // namespace aula::godot
