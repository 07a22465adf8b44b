#pragma once

#include <cstdint>
#include <vector>

#include "aula/engine/bands.h"
#include "aula/engine/vec3.h"
#include "engine/trace/deposit.h"
#include "engine/trace/path_identifier.h"

namespace aula {

/// A segment of a path that no gather finds; receivers detect it later.
struct PathSegment {
    Vec3 origin{0};
    Vec3 direction{0};  ///< unit
    float length_m = 0;
    float before_m = 0;  ///< length of the path up to the segment
    float growth = 0;    ///< of its detection sphere, see size_spheres()
};

/// Energy and direction of a segment.
struct SegmentEnergy {
    Bands energy;  ///< at the segment's start, for a ray of energy 1
    Vec3 from{0};  ///< unit, from the listener to the origin of the sound, whichever end emits
    /// ImageTransform::key of a purely specular path that an image source may count, else 0. The
    /// path contributes where that image is not tried (SpecularSound::tried).
    std::uint64_t image = 0;
};

/// Results of one batch of rays that every tracer collects, ordered by reflection.
struct TraceBatch {
    std::vector<PathSegment> segments;
    std::vector<SegmentEnergy> segment_energies;  ///< [segment]
    std::vector<Vec3> departures;                 ///< [ray] initial direction
    std::uint64_t segment_count = 0;              ///< traced, of all paths

    void clear() {
        segments.clear();
        segment_energies.clear();
        departures.clear();
        segment_count = 0;
    }
};

/// A ray that crossed a receiver's sphere after its last reflection.
struct Arrival {
    PathIdentifier path;  ///< emitter, patches, receiver
    std::uint32_t receiver = 0;
    float length_m = 0;  ///< path length to the middle of the chord
    Vec3 direction{0};  ///< unit, from the listener to the origin of the sound, whichever end emits
    Bands energy;       ///< energy * chord / sphere volume, 1/m2, for a ray of energy 1
    std::uint64_t image = 0;  ///< see SegmentEnergy
};

/// Results of an ArrivalTracer.
struct ArrivalBatch : TraceBatch {
    std::vector<Arrival> arrivals;
    std::vector<PathIdentifier> segment_identifiers;  ///< [segment]

    void clear() {
        TraceBatch::clear();
        arrivals.clear();
        segment_identifiers.clear();
    }
};

/// Results of a DepositTracer.
struct DepositBatch : TraceBatch {
    DepositParts deposits;

    void clear() {
        TraceBatch::clear();
        deposits.clear();
    }
};

}  // namespace aula
