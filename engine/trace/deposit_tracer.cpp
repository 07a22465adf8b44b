#include "engine/trace/deposit_tracer.h"

#include <array>

#include "engine/base/band_vector.h"
#include "process/multiversion.h"

namespace aula {

namespace {

/// The share of the longest path from which on the next diffuse reflection of a path is a start:
/// early ones are observed for longer.
constexpr std::array<float, PathStarts::kCount> kStarts{0, 1.0F / 16, 1.0F / 4, 9.0F / 16};

/// From this time on, hits show how energy is distributed late in the response.
constexpr double kLate_s = 0.1;

/// What is collected of a batch of paths.
struct Collector {
    const RayScene& scene;
    const TimeBins& bins;
    const TraceSettings& settings;
    const DepositTracer::Regions& regions;
    DepositTracer::Extent extent;
    const std::array<std::uint32_t, kLanes>& rows;
    const std::array<float, kLanes>& factors;

    double s_per_m = 1 / double{settings.speed_of_sound_m_s};
    std::size_t late_bin = bins.index(kLate_s);

    bool teaches() const {
        return extent == DepositTracer::Extent::teaching ||
               extent == DepositTracer::Extent::handed_over;
    }
    bool is_predicted() const {
        return extent == DepositTracer::Extent::handed_over ||
               extent == DepositTracer::Extent::near;
    }

    std::size_t bin(float length_m) const { return bins.index(double{length_m} * s_per_m); }

    /// The deposits of path `i`, whose scattered energy is `energy`, for its starts.
    [[gnu::always_inline]] void add_transport(const PathBatch& paths, std::size_t i,
                                              const BandVector& energy, DepositBatch& out) const {
        const PathStarts& starts = paths.starts[i];
        const std::uint32_t region = regions.of_row[rows[i]];
        if (region == PatchGrid::kNone) return;
        const auto count = static_cast<std::uint32_t>(regions.count);
        for (std::size_t s = 0; s < starts.count; ++s) {
            const float after_m = paths.length_m[i] - starts.length_m[s];
            const std::size_t after = bin(after_m);
            if (after_m < regions.hand_over_m || after >= starts.end_bin[s]) continue;
            Deposit deposit;
            deposit.patch = regions.of_row[starts.row[s]] * count + region;
            deposit.bin = static_cast<std::uint16_t>(after);
            deposit.set_energy(energy * starts.per_energy[s], paths.roulette[i]);
            if (!deposit.empty()) out.transport.add(deposit);
        }
    }

    /// True if the reflection of path `i` is its next start.
    bool is_start(const PathBatch& paths, std::size_t i) const {
        const std::size_t next = paths.starts[i].count;
        if (paths.to_diffuse[i] == 0 || paths.ended[i] != 0 || next == PathStarts::kCount ||
            !regions.is_start(rows[i]))
            return false;
        if (next == 0) return true;
        return teaches() && paths.length_m[i] >= kStarts[next] * settings.max_length_m;
    }

    void add_start(PathBatch& paths, std::size_t i, DepositBatch& out) const {
        PathStarts& starts = paths.starts[i];
        const std::size_t next = starts.count++;
        starts.row[next] = rows[i];
        starts.length_m[next] = paths.length_m[i];
        starts.per_energy[next] = 1 / paths.energy[i].max();
        starts.end_bin[next] =
            static_cast<std::uint16_t>(bin(settings.max_length_m - paths.length_m[i]));
        if (!teaches()) return;
        out.starts.push_back(
            {rows[i], starts.end_bin[next], paths.energy[i] * starts.per_energy[next]});
    }

    void add_late_hit(const PathBatch& paths, std::size_t i, DepositBatch& out) const {
        const std::size_t at = bin(paths.length_m[i]);
        if (at < late_bin || paths.behind_walls) return;
        const Material& material = scene.material(paths.material[i]);
        float energy = 0;
        for (std::size_t b = 0; b < kBandCount; ++b) {
            const float scattered = material.scattering[b] * (1 - material.absorption[b]);
            if (scattered > 0) energy += paths.scattered[i][b] / scattered;
        }
        out.late_hits.push_back({rows[i], static_cast<std::uint32_t>(at), energy});
    }
};

AULA_MULTIVERSION
void add_deposits(PathBatch& paths, const Collector& collector, DepositBatch& out) {
    using enum DepositTracer::Extent;
    const DepositTracer::Extent extent = collector.extent;
    for (std::size_t i = 0; i < paths.count; ++i) {
        const std::uint32_t row = collector.rows[i];
        const std::size_t bin = collector.bin(paths.length_m[i]);
        if (row == PatchGrid::kNone || bin >= collector.bins.count()) continue;
        const BandVector scattered = load_bands(paths.scattered[i]);
        const BandVector energy = collector.factors[i] * scattered;
        const PathStarts& starts = paths.starts[i];
        const bool later =
            starts.any() && paths.length_m[i] - starts.length_m[0] >= collector.regions.hand_over_m;
        if (later && extent == near) {
            paths.ended[i] = 1;
            // Paths behind walls end without energy.
            paths.energy[i] = Bands();
            continue;
        }
        Deposit deposit;
        deposit.patch = row;
        deposit.bin = static_cast<std::uint16_t>(bin);
        deposit.ray = static_cast<std::uint8_t>(paths.ray[i]);
        // The random number of the roulette is independent of the diffuse energy.
        deposit.set_energy(energy, paths.roulette[i]);
        if (!deposit.empty()) (later ? out.later : out.deposits).add(deposit);
        if (extent == whole) continue;
        if (!starts.any() && collector.is_predicted() && collector.regions.is_start(row)) {
            deposit.patch = collector.regions.of_row[row];
            deposit.set_energy(scattered * collector.regions.importance[row], paths.roulette[i]);
            if (!deposit.empty()) out.handed_over.add(deposit);
        }
        if (collector.teaches()) collector.add_transport(paths, i, energy, out);
        if (collector.is_start(paths, i)) {
            collector.add_start(paths, i, out);
        } else if (later) {
            // Not of starts: the importance of a row would depend on its own starts.
            collector.add_late_hit(paths, i, out);
        }
    }
}

static_assert(kLanes <= 256, "a deposit has eight bits for its ray");

}  // namespace

void DepositTracer::trace(const Emitter& emitter, std::uint64_t frame_seed, int batch,
                          Extent extent, DepositBatch& out) const {
    const auto collect = [&](const PathBatch& paths, int order) {
        count_segments(paths, order, out);
        collect_segments(paths, order, emitter, out);
    };
    follow(emitter, frame_seed, batch, last_order(), Paths::all, collect,
           [&](PathBatch& paths) { collect_deposits(paths, extent, out); });
}

/// Collects the present segments of paths that neither gather nor image sources find.
void DepositTracer::collect_segments(const PathBatch& paths, int order, const Emitter& emitter,
                                     DepositBatch& out) const {
    const bool specular = traces_specular_of(paths, order);
    const bool after_mirrors = order_is_limited();
    if (!specular && !after_mirrors) return;
    for (std::size_t i = 0; i < paths.count; ++i) {
        const bool collected = paths.diffuse[i] != 0 ? after_mirrors && paths.to_diffuse[i] == 0
                                                     : specular && counts_specular(paths, order, i);
        if (collected) add_segment(paths, i, order, emitter, out);
    }
}

void DepositTracer::collect_deposits(PathBatch& paths, Extent extent, DepositBatch& out) const {
    std::array<std::uint32_t, kLanes> rows;
    std::array<float, kLanes> factors;
    grid_.find_rows(paths.point, paths.normal, paths.count, rows, factors);
    const Collector collector{scene(), bins_, settings(), regions_, extent, rows, factors};
    best_version<add_deposits>(paths, collector, out);
}

}  // namespace aula
