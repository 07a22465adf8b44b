#include "engine/trace/detection_spheres.h"

#include <algorithm>
#include <vector>

#include "engine/base/air_attenuation.h"
#include "engine/base/band_vector.h"
#include "process/multiversion.h"

namespace aula {

namespace {

/// Growth of the spheres of segments of up to kEven times the mean energy, in their band of most
/// energy. Choices: late hits are four times as many, and the strongest of these count four mean
/// ones.
constexpr float kLeastGrowth = 4;
constexpr float kEven = 16;  // four mean energies in a sphere of four times the cross-section

/// Bands with a lower mean are ignored: at -100 dB they are not heard beside others, and would
/// decide by the ratio.
constexpr float kMinMean = 1e-10F;

/// Sums over the segments that begin at about the same path length.
struct LengthBin {
    Bands energy;
    float count = 0;
};

AULA_MULTIVERSION
void add_energies(const TraceBatch& batch, float bins_per_m, std::vector<LengthBin>& bins) {
    for (std::size_t i = 0; i < batch.segments.size(); ++i) {
        const auto k = static_cast<std::size_t>(batch.segments[i].before_m * bins_per_m);
        if (k >= bins.size()) bins.resize(k + 1);
        store_bands(load_bands(bins[k].energy) + load_bands(batch.segment_energies[i].energy),
                    bins[k].energy.value.data());
        bins[k].count += 1;
    }
}

/// The largest ratio over all bands decides, as each band may be audible alone.
AULA_MULTIVERSION
void set_growth(const std::vector<Bands>& inverse, float bins_per_m, TraceBatch& batch) {
    for (std::size_t i = 0; i < batch.segments.size(); ++i) {
        const auto k = static_cast<std::size_t>(batch.segments[i].before_m * bins_per_m);
        const BandVector ratio =
            load_bands(batch.segment_energies[i].energy) * load_bands(inverse[k]);
        batch.segments[i].growth = batch.segment_energies[i].image == 0
                                       ? std::max(kLeastGrowth, max_of_bands(ratio)[0])
                                       : 0;
    }
}

}  // namespace

template <typename Batch>
void size_spheres(std::span<Batch> batches) {
    // Bins as wide as the mean segment hold about one segment of each ray.
    double length_m = 0;
    double count = 0;
    for (const TraceBatch& batch : batches) {
        for (const PathSegment& segment : batch.segments) length_m += double{segment.length_m};
        count += static_cast<double>(batch.segments.size());
    }
    if (!(length_m > 0)) return;
    const auto bins_per_m = static_cast<float>(count / length_m);
    std::vector<LengthBin> bins;
    for (const TraceBatch& batch : batches) best_version<add_energies>(batch, bins_per_m, bins);
    std::vector<Bands> inverse(bins.size());
    for (std::size_t k = 0; k < bins.size(); ++k) {
        for (std::size_t b = 0; b < kBandCount; ++b) {
            const float energy = bins[k].energy[b];
            if (energy > kMinMean * bins[k].count) {
                inverse[k][b] = kLeastGrowth * bins[k].count / (kEven * energy);
            }
        }
    }
    for (TraceBatch& batch : batches) best_version<set_growth>(inverse, bins_per_m, batch);
}

template void size_spheres(std::span<ArrivalBatch> batches);
template void size_spheres(std::span<DepositBatch> batches);

void collect_segment_arrivals(const RayScene& scene, std::span<const Receiver> receivers,
                              const Bands& attenuation_per_m, int rays, ArrivalBatch& batch) {
    for (std::uint32_t r = 0; r < receivers.size(); ++r) {
        const float wave_front_1_m2 = wave_front_growth_1_m2(rays, receivers[r].radius_m);
        for (std::size_t i = 0; i < batch.segments.size(); ++i) {
            const PathSegment& segment = batch.segments[i];
            const float growth = sphere_growth(segment.growth, segment.before_m, wave_front_1_m2);
            const auto chord = receivers[r].chord(scene, segment.origin, segment.direction,
                                                  segment.length_m, Receiver::sphere_of(growth));
            if (!chord) continue;
            const SegmentEnergy& sound = batch.segment_energies[i];
            const Bands energy =
                sound.energy * transmission(attenuation_per_m, chord->at_m) * chord->share_1_m2;
            // Paths that an image source may count have separate entries.
            PathIdentifier path = batch.segment_identifiers[i].ended(r);
            path.low ^= sound.image;
            batch.arrivals.push_back(
                {path, r, segment.before_m + chord->at_m, sound.from, energy, sound.image});
        }
    }
}

}  // namespace aula
