#pragma once

#include <string>

#include "apps/room/base/playback_options.h"
#include "apps/room/frames/frame_view.h"
#include "apps/room/frames/play_controls.h"
#include "apps/window/model/edited_scene.h"

namespace aula {

/// The scene as it plays: with the given simulation settings, and the gains and poses of the
/// controls. A source that was moved loses its trajectory; a listener with one keeps it.
Scene played_scene(Scene scene, const PlayControls& controls, const Simulation& simulation);

// Files that the window saves in the working directory. Each function returns a message that names
// the files. They throw InputError or Failure.

/// Saves the scene as it plays to STEM-edited.json: with the given simulation settings, and the
/// gains and positions of the controls. A listener with a trajectory keeps it. The scene of a model
/// begins with a comment, as `aula import` writes it.
std::string save_played_scene(const EditedScene& edited, const PlayControls& controls,
                              const Simulation& simulation);

/// Saves the impulse response of a view to STEM-ir.wav and its ISO 3382 report to STEM-report.json.
/// `scene` is that of the view. Reads the HRTF, which takes a second. [any thread]
std::string save_response(const Scene& scene, const FrameView& view,
                          const PlaybackOptions& playback, const std::string& stem);

}  // namespace aula
