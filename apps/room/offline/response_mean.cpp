#include "apps/room/offline/response_mean.h"

#include <algorithm>
#include <bit>
#include <cassert>

namespace aula {

namespace {

using Floats = std::array<float, kBandCount>;
static_assert(sizeof(DirectionMoments) == sizeof(Floats));

template <typename Values>
void add_weighted(double weight, const Values& values, std::array<double, kBandCount>& sums) {
    for (std::size_t i = 0; i < sums.size(); ++i)
        sums[i] += weight * static_cast<double>(values[i]);
}

Bands scaled(const std::array<double, kBandCount>& sums, double scale) {
    Bands out;
    for (std::size_t band = 0; band < kBandCount; ++band)
        out[band] = static_cast<float>(sums[band] * scale);
    return out;
}

}  // namespace

void ResponseMean::begin_like(const EnergyResponse& response) {
    if (weight_ > 0) return;
    first_ = response;
    energy_.resize(response.energy.size());
    directions_.resize(response.directions.size());
}

void ResponseMean::add(const EnergyResponse& response, double weight) {
    begin_like(response);
    weight_ += weight;
    for (std::size_t bin = 0; bin < energy_.size(); ++bin) {
        add_weighted(weight, response.energy[bin].value, energy_[bin]);
        add_weighted(weight, std::bit_cast<Floats>(response.directions[bin]), directions_[bin]);
    }
    for (const SoundPath& path : response.paths) {
        PathSum& sum = paths_.try_emplace(path.key, PathSum{path}).first->second;
        for (std::size_t band = 0; band < kBandCount; ++band)
            sum.energy[band] += weight * static_cast<double>(path.energy[band]);
    }
}

void ResponseMean::add(const ResponseMean& other) {
    if (other.weight_ == 0) return;
    begin_like(other.first_);
    weight_ += other.weight_;
    for (std::size_t bin = 0; bin < energy_.size(); ++bin) {
        add_weighted(1, other.energy_[bin], energy_[bin]);
        add_weighted(1, other.directions_[bin], directions_[bin]);
    }
    for (const auto& [id, path] : other.paths_) {
        PathSum& sum = paths_.try_emplace(id, PathSum{path.path}).first->second;
        for (std::size_t band = 0; band < kBandCount; ++band) sum.energy[band] += path.energy[band];
    }
}

EnergyResponse ResponseMean::value() const {
    assert(weight_ > 0);
    EnergyResponse mean = first_;
    const double share = 1.0 / weight_;
    for (std::size_t bin = 0; bin < energy_.size(); ++bin) {
        mean.energy[bin] = scaled(energy_[bin], share);
        mean.directions[bin] =
            std::bit_cast<DirectionMoments>(scaled(directions_[bin], share).value);
    }
    mean.paths.clear();
    for (const auto& [id, sum] : paths_) {
        mean.paths.push_back(sum.path);
        mean.paths.back().energy = scaled(sum.energy, share);
    }
    std::stable_sort(
        mean.paths.begin(), mean.paths.end(),
        [](const SoundPath& a, const SoundPath& b) { return a.length_m < b.length_m; });
    return mean;
}

}  // namespace aula
