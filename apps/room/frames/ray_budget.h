#pragma once

#include <cstddef>
#include <string>

#include "aula/engine/frame.h"
#include "aula/engine/simulation.h"

namespace aula {

/// The number of rays with which the next frame takes `allowed_s`: the last frame's rays, changed
/// in a limited step according to the times of its rays and of its other parts, at least
/// fewest_rays(). Unchanged if the last frame traced none.
int rays_within_budget(int rays, const FrameStatistics& last, double last_frame_s, double allowed_s,
                       std::size_t sources);

/// The fewest rays per source and frame that a budget sets: with more sources fewer each, since the
/// errors of n sources that are equally loud are independent, and that of their sum is the one of a
/// single source with n times the rays.
int fewest_rays(std::size_t sources);

/// The time of tracing, gathering and image sources of a frame on one processor, in s, as counted.
/// It does not depend on the machine or on the number of threads, and is about within a factor of
/// two of the time that `aula-bench budget` measures on one core of a 2.3 GHz Xeon.
double counted_s(const FrameStatistics& statistics);

/// The counted time that a frame of exact rendering may take, in s: that of `quality` for one frame
/// period. Infinite for Quality::fine.
double allowed_s(Quality quality, double frame_period_s);

/// A warning if the frames of exact rendering took clearly more counted time than the quality
/// allows because none may have fewer rays than fewest_rays(); empty otherwise. `counted_frame_s`:
/// their mean; `rays`: of the last one.
std::string over_budget_text(const Simulation& simulation, std::size_t sources, int rays,
                             double counted_frame_s);

/// The rays that live playback begins with, and takes unless its frames are late: those of the
/// scene. If it names none, Simulation::kRays, or with Quality::draft the share of them that its
/// time is of the time of Quality::normal.
int live_rays(const Simulation& simulation);

/// The number of rays with which the next frame takes `allowed_s` of counted time: the last frame's
/// rays, changed in proportion, at least fewest_rays(), at most Simulation::kRays.
int rays_within_work(int rays, const FrameStatistics& last, double allowed_s, std::size_t sources);

}  // namespace aula
