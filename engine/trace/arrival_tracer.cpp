#include "engine/trace/arrival_tracer.h"

#include "engine/base/air_attenuation.h"

namespace aula {

void ArrivalTracer::trace(const Emitter& emitter, std::span<const Receiver> receivers,
                          std::uint64_t frame_seed, int batch, ArrivalBatch& out) const {
    const auto collect = [&](const PathBatch& paths, int order) {
        count_segments(paths, order, out);
        collect_segments(paths, order, emitter, out);
        collect_arrivals(paths, emitter, receivers, out);
    };
    follow(emitter, frame_seed, batch, last_order(), Paths::all, collect,
           [&](PathBatch& paths) { extend_identifiers(paths); });
}

/// Collects the present segments of purely specular paths that image sources do not list.
void ArrivalTracer::collect_segments(const PathBatch& paths, int order, const Emitter& emitter,
                                     ArrivalBatch& out) const {
    if (!traces_specular_of(paths, order)) return;
    for (std::size_t i = 0; i < paths.count; ++i) {
        if (!counts_specular(paths, order, i)) continue;
        add_segment(paths, i, order, emitter, out);
        out.segment_identifiers.push_back(paths.identifier[i]);
    }
}

/// Collects the receivers' arrivals from the present segments of diffusely reflected paths.
void ArrivalTracer::collect_arrivals(const PathBatch& paths, const Emitter& emitter,
                                     std::span<const Receiver> receivers, ArrivalBatch& out) const {
    for (std::uint32_t r = 0; r < receivers.size(); ++r) {
        for (std::size_t i = 0; i < paths.count; ++i) {
            if (paths.diffuse[i] == 0) continue;
            const auto chord =
                receivers[r].chord(scene(), paths.rays.origin.at(i), paths.rays.direction.at(i),
                                   std::min(paths.hits.distance_m[i], paths.rays.max_m[i]));
            if (!chord) continue;
            const Bands energy = paths.energy[i] *
                                 transmission(settings().attenuation_per_m, chord->at_m) *
                                 chord->share_1_m2;
            out.arrivals.push_back({paths.identifier[i].ended(r), r,
                                    paths.length_m[i] + chord->at_m,
                                    direction_at_listener(paths, i, emitter, out), energy});
        }
    }
}

void ArrivalTracer::extend_identifiers(PathBatch& paths) const {
    for (std::size_t i = 0; i < paths.count; ++i) {
        const Hit hit{paths.hits.triangle[i], paths.hits.distance_m[i], paths.hits.u[i],
                      paths.hits.v[i]};
        paths.identifier[i] =
            paths.identifier[i].extended(subdivision_.patch(hit, paths.back[i] != 0));
    }
}

}  // namespace aula
