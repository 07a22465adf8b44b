#include "engine/estimate/response_follower.h"

#include <algorithm>
#include <cmath>

namespace aula {

namespace {

/// Responses are smoothed from this time on. Before it, patterns of single reflections change while
/// the energy of a group may not.
constexpr double kBegin_s = 0.032;

/// Bins of a group. A choice: 16 ms of the first ones. Of more, errors of its parts cancel; of
/// fewer, errors are noise.
constexpr std::size_t kGroupBins = 16;

/// A bin wider than the first of its group by more than this factor begins the next one: widths
/// double, but for the last bin.
constexpr float kSameWidth = 1.5F;

/// Share of a new error in the smoothed ones. A smaller one detects changes later, a larger one
/// takes more noise for a change. A choice: two thirds of a second at 30 frames per second.
constexpr float kErrorShare = 1.0F / 20;

/// Mean square of the tracking signal of normally distributed noise: pi / 2 times kErrorShare / (2
/// - kErrorShare).
constexpr float kNoiseSignal = 0.04F;
static_assert(kNoiseSignal > 1.57F * kErrorShare / (2 - kErrorShare) - 1e-3F &&
              kNoiseSignal < 1.58F * kErrorShare / (2 - kErrorShare) + 1e-3F);

/// Smoothed absolute error from which on the smoothed error says nothing about a lag: after an
/// abrupt change, or where an error is cut off at 1. A choice: at a quarter of the energy its share
/// of the lag would itself be as large as a step of 1 dB.
constexpr float kUnreliable = 0.25F;

/// Least change of a level in a frame, 6 dB. A choice: a lower one lets a silent estimate, as of no
/// detection, end a response.
constexpr float kLeastFactor = 0.25F;

/// An error of a group is an outlier from this many times its mean magnitude on: of normally
/// distributed errors one of 700.
constexpr float kOutlier = 4;

/// Least error of a group, which limits its weight in the common level, and its square: 0.004 dB,
/// which is not heard.
constexpr float kLeastError = 1e-3F;
constexpr float kLeastSquare = kLeastError * kLeastError;

/// Sets bins [first_bin, end_bin) to `factor` times those of another response.
void scale(const EnergyResponse& from, std::size_t first_bin, std::size_t end_bin, float factor,
           EnergyResponse& to) {
    for (std::size_t k = first_bin; k < end_bin; ++k) {
        for (std::size_t b = 0; b < kBandCount; ++b) to.energy[k][b] = factor * from.energy[k][b];
        to.directions[k] = from.directions[k] * factor;
    }
}

/// Frames over which the prediction errors of a filter are averaged: as many as the errors of
/// groups.
constexpr int kPredictions = static_cast<int>(2 / kErrorShare);

}  // namespace

float LevelFilters::follow(float error) {
    frames_ = std::min(frames_ + 1, kPredictions);
    for (std::size_t f = 0; f < filters_.size(); ++f) {
        Filter& filter = filters_[f];
        const float gain = kGains[f];
        const float predicted = filter.level + filter.slope;
        const float residual = error - predicted;
        filter.level = predicted + gain * residual;
        // Half of the gain of Benedict and Bordner (1962).
        filter.slope += gain * gain / (2 * (2 - gain)) * residual;
        filter.squared_error +=
            (residual * residual - filter.squared_error) / static_cast<float>(frames_);
    }
    const auto by_error = [](const Filter& a, const Filter& b) {
        return a.squared_error < b.squared_error;
    };
    const float least = std::min_element(filters_.begin(), filters_.end(), by_error)->squared_error;
    float sum = 0;
    float weights = 0;
    for (std::size_t f = 0; f < filters_.size(); ++f) {
        const Filter& filter = filters_[f];
        // The likelihood of frames_ normally distributed errors over that of the least ones.
        const float ratio = (least + kLeastSquare) / (filter.squared_error + kLeastSquare);
        const float weight =
            kPriors[f] * static_cast<float>(std::pow(double{ratio}, frames_ / 2.0));
        sum += weight * filter.level;
        weights += weight;
    }
    const float change = std::max(sum / weights, kLeastFactor - 1);
    for (Filter& filter : filters_) {
        filter.level = (1 + filter.level) / (1 + change) - 1;
        filter.slope /= 1 + change;
    }
    return 1 + change;
}

void approach(const EnergyResponse& estimate, std::size_t first_bin, std::size_t end_bin,
              float share, EnergyResponse& response) {
    // Not as a change by a share of the difference: where a response decays suddenly, its rounding
    // leaves intensities that are longer than their energies.
    share = std::min(share, 1.0F);
    const float kept = 1 - share;
    for (std::size_t k = first_bin; k < end_bin; ++k) {
        response.energy[k] = response.energy[k] * kept + estimate.energy[k] * share;
        response.directions[k] = response.directions[k] * kept + estimate.directions[k] * share;
    }
}

ResponseFollower::ResponseFollower(const EnergyResponse& silent, int window_frames)
    : most_frames_(std::min(window_frames, kMostFrames)), smoothed_(silent), response_(silent) {
    const TimeBins& bins = silent.bins;
    const auto width_s = [&](std::size_t bin) { return bins.end_s(bin) - bins.begin_s(bin); };
    for (std::size_t bin = bins.index(kBegin_s); bin < bins.count(); ++bin) {
        const auto width_m = static_cast<float>(width_s(bin)) * silent.speed_of_sound_m_s;
        if (groups_.empty() || bin - groups_.back().first_bin == kGroupBins ||
            width_m > kSameWidth * groups_.back().width_m) {
            groups_.push_back({.first_bin = bin, .width_m = width_m});
        }
        groups_.back().end_bin = bin + 1;
    }
}

void ResponseFollower::follow(const EnergyResponse& estimate, int frames, double moved_m) {
    ++frames_;
    const std::size_t early_end = groups_.empty() ? response_.bins.count() : groups_[0].first_bin;
    approach(estimate, 0, early_end, 1, response_);
    const float least =
        static_cast<float>(frames) / static_cast<float>(std::min(frames_, most_frames_));
    for (Group& group : groups_) compare(estimate, smoothed_, group);
    // At rest the estimates are means of the frames since the movement, and have no trend.
    if (moved_m == 0 || frames_ <= 2) {
        level_ = {};
    } else {
        follow_level();
    }
    for (Group& group : groups_) {
        const float error = std::min(group.newest_error, 1.0F);
        if (frames_ == 1) group.error = group.absolute_error = 0;
        if (frames_ == 2) group.absolute_error = std::abs(error);
        if (frames_ > 1) {
            group.error += kErrorShare * (error - group.error);
            group.absolute_error += kErrorShare * (std::abs(error) - group.absolute_error);
        }
        const float signal = group.absolute_error > 0 ? group.error / group.absolute_error : 0.0F;
        // Of moving ends, so that paths change by less than a bin in the mean age of frames.
        const float share =
            std::max({signal * signal, least, static_cast<float>(moved_m) / group.width_m});
        approach(estimate, group.first_bin, group.end_bin, share, smoothed_);
        const float behind = moved_m > 0 ? lag(group, share) : 0;
        scale(smoothed_, group.first_bin, group.end_bin, 1 + behind, response_);
    }
}

/// The share of a group's smoothed error that is not in doubt.
float ResponseFollower::reliability(const Group& group) {
    return std::max(0.0F, 1 - group.absolute_error / kUnreliable);
}

/// Follows the mean error of all groups, weighted by their bins over their variance, and less if it
/// is an outlier. Where few groups are reliable, as with sparse detections, it counts less.
void ResponseFollower::follow_level() {
    float sum = 0;
    float weights = 0;
    float reliable_bins = 0;
    float bins = 0;
    for (const Group& group : groups_) {
        if (group.silent) continue;
        const float error = std::min(group.newest_error, 1.0F);
        const float deviation =
            std::max({group.absolute_error, std::abs(error) / kOutlier, kLeastError});
        const auto count = static_cast<float>(group.end_bin - group.first_bin);
        const float reliable = count * reliability(group);
        sum += reliable * error / (deviation * deviation);
        weights += reliable / (deviation * deviation);
        reliable_bins += reliable;
        bins += count;
    }
    if (weights == 0) {
        level_ = {};
        return;
    }
    const float factor = level_.follow(sum / weights * reliable_bins / bins);
    for (Group& group : groups_) {
        if (group.silent) continue;
        scale(smoothed_, group.first_bin, group.end_bin, factor, smoothed_);
        group.newest_error = (1 + group.newest_error) / factor - 1;
    }
}

/// The relative amount by which a group of the smoothed response is behind the estimates, of which
/// its last share was `share`.
float ResponseFollower::lag(const Group& group, float share) {
    if (share >= 1 || !(group.absolute_error > 0)) return 0;
    const float signal = group.error / group.absolute_error;
    const float certain = signal * signal / (signal * signal + kNoiseSignal);
    return (1 - share) * certain * reliability(group) * group.error;
}

/// Sets a group's newest error: the energy of the estimate over that of the response, less one.
void ResponseFollower::compare(const EnergyResponse& estimate, const EnergyResponse& response,
                               Group& group) {
    float difference = 0;
    float all = 0;
    for (std::size_t k = group.first_bin; k < group.end_bin; ++k) {
        const float before = response.energy[k].sum();
        difference += estimate.energy[k].sum() - before;
        all += before;
    }
    group.silent = !(all > 0);
    group.newest_error = all > 0 ? difference / all : difference > 0 ? 1.0F : 0.0F;
}

}  // namespace aula
