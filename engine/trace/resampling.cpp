#include "engine/trace/resampling.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/base/band_vector.h"
#include "engine/base/sampling.h"
#include "engine/trace/path_batch.h"

namespace aula {

namespace {

/// Paths that have passed one wall, two, and more. A choice: what has passed three is mostly below
/// what has passed one.
constexpr std::size_t kGenerations = 3;

/// Each generation has one of as many places, however weak it is: all have half of the places, the
/// rest follow the energies.
constexpr std::size_t kReserved = 2 * kGenerations;
static_assert(Thinning::kFewest >= kReserved, "a generation has no place");

struct Generation {
    BandVector total{};     ///< energy
    std::size_t count = 0;  ///< paths
    std::size_t places = 0;
    double importance = 0;  ///< sum over its paths

    // Position in the systematic sequence.
    double step = 0;
    double passed = 0;
    double next = 0;
};

using Generations = std::array<Generation, kGenerations>;

std::size_t generation_of(std::uint32_t walls_passed) {
    return std::clamp<std::size_t>(walls_passed, 1, kGenerations) - 1;
}

/// Divides the places among the generations.
void divide(std::size_t places, Generations& generations) {
    std::size_t left = places;
    BandVector all{};
    for (Generation& g : generations) {
        g.places = std::min(g.count, places / kReserved);
        left -= g.places;
        all += g.total;
    }
    std::array<float, kGenerations> share{};
    float sum = 0;
    for (std::size_t k = 0; k < kGenerations; ++k) {
        share[k] = sum_of_bands(all > 0 ? generations[k].total / all : BandVector{})[0];
        sum += share[k];
    }
    for (std::size_t k = 0; k < kGenerations; ++k) {
        Generation& g = generations[k];
        const float more = sum > 0 ? static_cast<float>(left) * share[k] / sum : 0;
        g.places = std::min(g.count, g.places + static_cast<std::size_t>(more));
    }
}

}  // namespace

float Thinning::next(double energy, double u) {
    if (!(energy > 0)) return 0;
    constexpr double kShare = double{kFewest} / double{kMost};
    highest_energy_ = std::max(highest_energy_, energy);
    const double thinning_from = double{PathBatch::kRouletteEnergy} * highest_energy_;
    const double share = std::sqrt(energy / thinning_from);
    places_ = static_cast<std::size_t>(double{kMost} * std::clamp(share, kShare, 1.0));
    const double roulette_from = thinning_from * kShare * kShare * survival_;
    if (!(energy < roulette_from)) return 1;
    const double survival = std::sqrt(energy / roulette_from);
    survival_ *= survival;
    return u < survival ? static_cast<float>(1 / survival) : 0;
}

std::span<const Resampler::Survivor> Resampler::choose(std::span<const Bands> energies,
                                                       std::span<const std::uint32_t> walls_passed,
                                                       std::size_t places, std::uint64_t seed) {
    const std::size_t count = energies.size();
    survivors_.clear();
    if (count <= places) {
        for (std::size_t i = 0; i < count; ++i) survivors_.push_back({i, 1});
        return survivors_;
    }
    Generations generations;
    for (std::size_t i = 0; i < count; ++i) {
        Generation& g = generations[generation_of(walls_passed[i])];
        g.total += load_bands(energies[i]);
        ++g.count;
    }
    divide(places, generations);
    importance_.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
        Generation& g = generations[generation_of(walls_passed[i])];
        importance_[i] =
            sum_of_bands(g.total > 0 ? load_bands(energies[i]) / g.total : BandVector{})[0];
        g.importance += double{importance_[i]};
    }
    for (std::size_t k = 0; k < kGenerations; ++k) {
        Generation& g = generations[k];
        if (g.places == 0) continue;
        g.step = g.importance / static_cast<double>(g.places);
        g.next = double{RandomStream(derive_seed(seed, k)).uniform()};
    }
    for (std::size_t i = 0; i < count; ++i) {
        Generation& g = generations[generation_of(walls_passed[i])];
        if (g.places == g.count) {
            survivors_.push_back({i, 1});
            continue;
        }
        g.passed += double{importance_[i]};
        const auto factor = static_cast<float>(g.step / double{importance_[i]});
        for (; g.next * g.step < g.passed; ++g.next) survivors_.push_back({i, factor});
    }
    return survivors_;
}

}  // namespace aula
