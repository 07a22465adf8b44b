#include "engine/rays/oriented_directivity.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "engine/base/sampling.h"

namespace aula {

namespace {

// Cells of the sphere that rays are drawn from. A choice: 2.8 degrees, half of what files of
// directivities resolve.
constexpr std::size_t kRows = 64;
constexpr std::size_t kColumns = 128;

/// Share of the rays that is uniform. It limits the energy of a ray where the factor varies within
/// a cell, and leaves no direction without rays.
constexpr float kUniformShare = 0.1F;

/// The directions in which turned_m() compares two orientations.
constexpr std::uint32_t kCompared = 128;

Vec3 cell_direction(float row, float column) {
    return uniform_direction(
        {row / static_cast<float>(kRows), column / static_cast<float>(kColumns)});
}

/// Cumulative sums of weights, from 0 to 1.
std::vector<float> cumulative(const std::vector<float>& weights) {
    std::vector<float> ends{0};
    double sum = 0;
    for (const float w : weights) ends.push_back(static_cast<float>(sum += double{w}));
    for (float& end : ends) end /= static_cast<float>(sum);
    ends.back() = 1;
    return ends;
}

/// The interval of a number below 1, and the number's position within it.
struct Interval {
    std::size_t index;
    float position;
    float probability;

    Interval(const std::vector<float>& ends, float u) {
        const auto next = std::upper_bound(ends.begin() + 1, ends.end() - 1, u);
        index = static_cast<std::size_t>(next - ends.begin()) - 1;
        probability = ends[index + 1] - ends[index];
        position = std::clamp((u - ends[index]) / probability, 0.0F, 1.0F);
    }
};

}  // namespace

EmissionSampler::EmissionSampler(const Directivity& directivity) : directivity_(directivity) {
    assert(!directivity.is_omnidirectional());
    std::vector<float> rows;
    for (std::size_t r = 0; r < kRows; ++r) {
        std::vector<float> columns;
        float sum = 0;
        for (std::size_t c = 0; c < kColumns; ++c) {
            const Vec3 middle =
                cell_direction(static_cast<float>(r) + 0.5F, static_cast<float>(c) + 0.5F);
            const float mean = directivity_.factor(middle).sum() / kBandCount;
            columns.push_back(kUniformShare + (1 - kUniformShare) * mean);
            sum += columns.back();
        }
        rows.push_back(sum);
        column_ends_.push_back(cumulative(columns));
    }
    row_ends_ = cumulative(rows);
}

std::pair<Vec3, Bands> EmissionSampler::sample(const std::array<float, 2>& u) const {
    const Interval row(row_ends_, u[0]);
    const Interval column(column_ends_[row.index], u[1]);
    const Vec3 direction = cell_direction(static_cast<float>(row.index) + row.position,
                                          static_cast<float>(column.index) + column.position);
    const float density = row.probability * column.probability * (kRows * kColumns);
    return {direction, directivity_.factor(direction) * (1 / density)};
}

std::pair<Vec3, Bands> OrientedDirectivity::sample(const std::array<float, 2>& u) const {
    if (is_omnidirectional()) return {uniform_direction(u), Bands::filled(1)};
    const auto [direction, energy] = sampler_->sample(u);
    return {rotation_ * direction, energy};
}

double OrientedDirectivity::turned_m(const OrientedDirectivity& before) const {
    if (is_omnidirectional() || rotation_ == before.rotation_) return 0;
    const ScrambledSobol directions(0);
    double change = 0;
    for (std::uint32_t i = 0; i < kCompared; ++i) {
        const Vec3 direction = uniform_direction(directions.point(i));
        const Bands now = factor(direction);
        const Bands then = before.factor(direction);
        for (std::size_t b = 0; b < kBandCount; ++b) change += double{std::abs(now[b] - then[b])};
    }
    // Never 0, as a turn is a change of the source.
    return std::max(1e-9, change / (kCompared * kBandCount));
}

}  // namespace aula
