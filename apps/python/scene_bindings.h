#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <utility>

#include "aula/engine/scene.h"

namespace aula {

/// A scene of Python. Functions without the interpreter's lock keep the scene that they began with:
/// a change replaces it by a changed copy.
class SharedScene {
 public:
    explicit SharedScene(Scene scene) : scene_(std::make_shared<const Scene>(std::move(scene))) {}

    const std::shared_ptr<const Scene>& get() const { return scene_; }

    /// Replaces the scene by a copy that `edit` has changed; keeps it if `edit` throws.
    void change(const auto& edit) {
        auto copy = std::make_shared<Scene>(*scene_);
        edit(*copy);
        scene_ = std::move(copy);
    }

 private:
    std::shared_ptr<const Scene> scene_;
};

/// Adds the classes of scenes, sources and materials.
void bind_scenes(pybind11::module_& module);

/// Adds measuring and rendering.
void bind_results(pybind11::module_& module);

/// Adds rooms that are played block by block.
void bind_auralizer(pybind11::module_& module);

/// Adds the analysis of measured responses.
void bind_analysis(pybind11::module_& module);

}  // namespace aula
