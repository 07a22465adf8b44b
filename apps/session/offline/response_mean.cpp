#include "apps/session/offline/response_mean.h"

#include <algorithm>
#include <cassert>

namespace aula {

namespace {

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
    intensity_.resize(response.intensity.size());
}

void ResponseMean::add(const EnergyResponse& response, double weight) {
    begin_like(response);
    weight_ += weight;
    for (std::size_t bin = 0; bin < energy_.size(); ++bin) {
        for (std::size_t band = 0; band < kBandCount; ++band)
            energy_[bin][band] += weight * static_cast<double>(response.energy[bin][band]);
        intensity_[bin] += weight * glm::dvec3(response.intensity[bin]);
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
        for (std::size_t band = 0; band < kBandCount; ++band)
            energy_[bin][band] += other.energy_[bin][band];
        intensity_[bin] += other.intensity_[bin];
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
        mean.intensity[bin] = Vec3(intensity_[bin] * share);
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
