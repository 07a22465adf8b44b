#pragma once

#include <cstddef>
#include <vector>

#include "aula.h"
#include "aula/auralizer.h"
#include "aula/engine/scene.h"

/// The scene of a handle.
struct aula_scene {
    aula::Scene scene;
};

namespace aula {

/// Throws InputError if the pointer is null.
Pose pose_of(const aula_pose* pose);

/// The directivity of a name, null: "omni". Throws InputError if there is none.
Directivity directivity_of(const char* name);

}  // namespace aula

/// The room of a handle.
struct aula_room {
    /// `given`: the options of the caller, of which `options` are made.
    aula_room(const aula::Scene& scene, const aula_options& given, aula::AuralizerOptions options);

    const aula_options given;  ///< its strings are not valid
    const aula::RenderClock clock;
    const std::size_t listeners;
    std::vector<aula::SourceSignal> signals;  ///< of one call; used by the thread that renders
    aula::Auralizer auralizer;
};
