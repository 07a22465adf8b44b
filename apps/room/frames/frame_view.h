#pragma once

#include <cstdint>
#include <vector>

#include "aula/engine/energy_response.h"
#include "aula/engine/frame.h"
#include "aula/engine/scene.h"

namespace aula {

/// The data of a frame that is requested for display.
struct ViewRequest {
    std::size_t source = 0;
    int lines = 0;  ///< number of requested ray paths
    int line_order = 5;
    bool edges = false;  ///< the edges that diffract sound
    bool patches = false;
    double patches_begin_s = 0;  ///< interval after emission for the patches' energies
    double patches_end_s = 10;
    std::size_t columns = 512;  ///< of the impulse response
};

/// A frame for display: copies of the data of one source.
struct FrameView {
    std::uint64_t frame = 0;   ///< number of the player's frame, counted through all changes
    std::uint64_t change = 0;  ///< number of the last change in this frame
    std::size_t source = 0;
    Pose listener;
    std::vector<Vec3> sources;
    std::vector<glm::mat3> source_rotations;  ///< from the local axes of each source
    Simulation simulation;
    EnergyResponse response;
    double length_s = 0;  ///< of the impulse response
    /// Largest pressure of the omnidirectional channel in each column's time interval, without
    /// `response.paths`.
    std::vector<float> impulse_response;
    std::vector<PathLine> lines;
    std::vector<EdgeLine> edges;
    std::vector<PatchEnergy> patches;
    float patch_size_m = 0;
};

}  // namespace aula
