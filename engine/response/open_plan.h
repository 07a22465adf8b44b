#pragma once

#include <cstddef>
#include <glm/geometric.hpp>
#include <optional>
#include <span>
#include <vector>

#include "aula/engine/bands.h"
#include "aula/engine/vec3.h"

namespace aula {

/// The A-weighted sum in dB of octave levels in dB (IEC 61672-1).
double a_weighted_db(const Bands& levels_db);

/// Speech of one talker at a receiver.
struct SpeechAtReceiver {
    Vec3 from_talker_m{0};      ///< position relative to the talker, not 0
    double level_dba = 0;       ///< A-weighted sound pressure level of the speech
    std::optional<double> sti;  ///< speech transmission index with the noise at the receiver

    double distance_m() const { return double{glm::length(from_talker_m)}; }
};

/// Single numbers of ISO 3382-3 for a line of receivers away from a talker in an open-plan office.
struct OpenPlanParameters {
    double d2s_db = 0;        ///< D2,S: decay of the A-weighted speech level per doubled distance
    double lp_as_4m_dba = 0;  ///< Lp,A,S,4m: A-weighted speech level at 4 m
    std::optional<double> rd_m;     ///< distraction distance: STI falls below 0.5; empty: nowhere
    std::optional<double> rp_m;     ///< privacy distance: STI falls below 0.2; empty: nowhere
    std::vector<std::size_t> line;  ///< indices of the receivers that these are of
};

/// The speech of ISO 3382-3, table 1: octave levels in dB at 1 m in free field of an
/// omnidirectional source, 57.4 dB(A) together. 63 Hz is not used.
inline constexpr Bands kOpenPlanSpeech_db{{-200, 49.9F, 54.3F, 58, 52, 44.8F, 38.8F, 33.5F}};

/// Distances of the receivers that count, in m, and the least number of these (ISO 3382-3).
inline constexpr double kOpenPlanFrom_m = 2;
inline constexpr double kOpenPlanTo_m = 16;
inline constexpr std::size_t kOpenPlanReceivers = 4;
/// Largest angle in degrees between the directions of a line's receivers and that of the one in its
/// middle: a choice. Workstations are not on a straight line.
inline constexpr double kOpenPlanAngle_deg = 15;
/// Largest difference in height of a line's receivers from that of the one in its middle, in m:
/// seated and standing people on one floor. Raked seats are no open-plan office.
inline constexpr double kOpenPlanLevel_m = 0.5;
/// The farthest receiver of a line is at least this times as far as the nearest: a slope per
/// doubled distance needs one.
inline constexpr double kOpenPlanRatio = 2;

/// Regression of the levels over the logarithm of the distance, and of the indices over the
/// distance, for the receivers on one floor in the direction in which most of them count. Empty if
/// these are fewer than kOpenPlanReceivers, or not kOpenPlanRatio apart. The distances rD and rP
/// are empty if an index is unknown, or if its line does not fall.
std::optional<OpenPlanParameters> open_plan_parameters(std::span<const SpeechAtReceiver> receivers);

}  // namespace aula
