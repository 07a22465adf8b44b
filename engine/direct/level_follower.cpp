#include "engine/direct/level_follower.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "engine/base/near_field.h"
#include "engine/direct/limits.h"

namespace aula {

namespace {

/// Movement in a frame below which an end begins to rest: a tenth of that of a walk.
constexpr double kResting_m = 5e-3;

/// Walked while a level follows. A choice: a third of a second of a walk, in which a change of 60
/// dB is a fade.
constexpr double kLongest_m = 0.5;

/// Remaining difference at which a level is that of the model: not heard, and a rest ends.
constexpr double kReached_db = 0.01;

/// The level of a pressure between those of two levels.
double between_db(double from_db, double to_db, double share) {
    const auto pressure = [](double level_db) {
        return level_db > limits::kSilence_db ? std::pow(10, level_db / 20) : 0;
    };
    const double from = pressure(from_db);
    const double between = from + share * (pressure(to_db) - from);
    return std::max(limits::kSilence_db, 20 * std::log10(std::max(between, 1e-30)));
}

}  // namespace

const Bands& LevelFollower::follow(const Vec3& source, const Vec3& listener, const Bands& model,
                                   bool has_moved) {
    const double walked_m =
        double{glm::distance(source, source_)} + double{glm::distance(listener, listener_)};
    const double straight_m = std::max(double{glm::distance(source, listener)}, kNearest_m);
    const double free_field = 1 / (4 * std::numbers::pi * straight_m * straight_m);
    const bool jumps = is_first_ || walked_m > double{limits::kJump_m};
    const double resting = has_moved ? 0.5 : 0.5 * std::max(0.0, 1 - walked_m / kResting_m);
    source_ = source;
    listener_ = listener;
    is_first_ = false;
    is_exact_ = true;
    energy_ = model;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const double model_db = std::max(
            limits::kSilence_db, 10 * std::log10(std::max(1e-30, double{model[b]}) / free_field));
        const double rest_db = std::abs(model_db - levels_db_[b]);
        const double step_db = walked_m * std::max(kSlope_db_m[b], rest_db / kLongest_m);
        if (jumps || rest_db <= std::max(step_db, kReached_db)) {
            levels_db_[b] = model_db;
            continue;
        }
        const double walked_db = levels_db_[b] + (model_db > levels_db_[b] ? step_db : -step_db);
        const double rested_db = between_db(levels_db_[b], model_db, resting);
        levels_db_[b] = model_db > levels_db_[b] ? std::max(walked_db, rested_db)
                                                 : std::min(walked_db, rested_db);
        is_exact_ = false;
        energy_[b] = static_cast<float>(std::pow(10, levels_db_[b] / 10) * free_field);
    }
    return energy_;
}

}  // namespace aula
