#pragma once

#include <cstdint>
#include <vector>

#include "engine/trace/arrival_tracer.h"
#include "engine/trace/detection_spheres.h"

namespace aula::test {

/// A scene as the tracer for arrivals sees it, with a listener of 0.5 m.
struct TracedRoom {
    Scene scene;
    RayScene rays;
    PatchSubdivision subdivision;
    TraceSettings settings;
    int specular_order = 0;
    float radius_m = 0.5F;

    explicit TracedRoom(const Scene& room) : scene(room), rays(scene), subdivision(rays, 0.5F) {
        settings.max_length_m = 300;
    }

    std::vector<Arrival> arrivals(std::uint64_t frame_seed) const {
        const SpecularPaths images(rays, specular_order, radius_m, 1);
        const ArrivalTracer tracer(rays, subdivision, images, settings);
        std::vector<Arrival> all;
        for (int b = 0; b < tracer.batch_count(); ++b) {
            ArrivalBatch batch;
            const Receiver receiver{scene.listener.pose.position, radius_m};
            tracer.trace({0, scene.sources[0].position}, {&receiver, 1}, frame_seed, b, batch);
            collect_segment_arrivals(rays, {&receiver, 1}, settings.attenuation_per_m,
                                     settings.rays, batch);
            all.insert(all.end(), batch.arrivals.begin(), batch.arrivals.end());
        }
        return all;
    }
};

}  // namespace aula::test
