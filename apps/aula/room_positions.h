#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "apps/aula/arguments/arguments.h"
#include "apps/aula/terminal/terminal.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// The seed of measurements of the room.
inline constexpr std::uint64_t kRoomSeed = 1;

inline constexpr const char* kMeasuring = "measuring the room";
inline constexpr const char* kListener = "the listener";

/// A position of the listener or of a source.
struct NamedPosition {
    std::string name;
    Vec3 position{0};
    std::optional<double> time_s;  ///< on the path; empty at rest or at its start
};

/// Initial positions of the listener, then of the sources.
std::vector<NamedPosition> initial_positions(const Scene& scene);

/// The initial positions and positions along all paths.
std::vector<NamedPosition> positions_along_paths(const Scene& scene);

std::vector<Vec3> points_of(const std::vector<NamedPosition>& positions);

/// Positions outside and inside the room.
struct SortedPositions {
    std::vector<NamedPosition> outside;
    std::vector<NamedPosition> inside;
};

SortedPositions sort_positions(const RayScene& rays, std::vector<NamedPosition> positions);

/// ", at (1, 2, 3)", after the time on a path.
std::string place_text(const NamedPosition& item);

/// "the listener is outside the room, at (1, 2, 3)".
std::string outside_text(const NamedPosition& item);

/// Those of `places` that sound does not reach from any of `others`, wherever movable objects are.
std::vector<NamedPosition> cut_off(const RayScene& rays, const std::vector<NamedPosition>& places,
                                   const std::vector<NamedPosition>& others);

/// The result of `work`. If it takes long, a status line on the terminal shows `what`.
template <typename Work>
auto result_of(const std::string& what, const Arguments& arguments, const Work& work) {
    const TaskLine line(what, !arguments.quiet);
    return work();
}

}  // namespace aula
