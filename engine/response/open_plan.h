#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "aula/engine/bands.h"

namespace aula {

/// The A-weighted sum in dB of octave levels in dB (IEC 61672-1).
double a_weighted_db(const Bands& levels_db);

/// Speech of one talker at a receiver.
struct SpeechAtReceiver {
    double distance_m = 0;      ///< from the talker, above 0
    double level_dba = 0;       ///< A-weighted sound pressure level of the speech
    std::optional<double> sti;  ///< speech transmission index with the noise at the receiver
};

/// Single numbers of ISO 3382-3 for a line of receivers away from a talker in an open-plan office.
struct OpenPlanParameters {
    double d2s_db = 0;        ///< D2,S: decay of the A-weighted speech level per doubled distance
    double lp_as_4m_dba = 0;  ///< Lp,A,S,4m: A-weighted speech level at 4 m
    std::optional<double> rd_m;  ///< distraction distance: STI falls below 0.5; empty: nowhere
    std::optional<double> rp_m;  ///< privacy distance: STI falls below 0.2; empty: nowhere
};

/// Distances of the receivers that count, in m, and the least number of these (ISO 3382-3).
inline constexpr double kOpenPlanFrom_m = 2;
inline constexpr double kOpenPlanTo_m = 16;
inline constexpr std::size_t kOpenPlanReceivers = 4;

/// The number of receivers at distances that count.
std::size_t open_plan_receivers(std::span<const SpeechAtReceiver> receivers);

/// Regression of the levels over the logarithm of the distance, and of the indices over the
/// distance. Empty if fewer than kOpenPlanReceivers count, or if they have all the same distance.
/// The distances rD and rP are empty if an index is unknown, or if the line does not fall.
std::optional<OpenPlanParameters> open_plan_parameters(std::span<const SpeechAtReceiver> receivers);

}  // namespace aula
