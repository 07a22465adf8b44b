#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace aula {

/// How energy responses are estimated (docs/algorithm.md).
enum class Estimator {
    pt,             ///< path tracing of each frame without a cache: the baseline of comparisons
    dpc_published,  ///< diffuse path cache as published, whose energies are biased
    dpc,            ///< diffuse path cache that averages over the last `response_time_s`
    patch           ///< energies cached by patches, with final gather: the least noise
};

/// The name in scene files and on the command line: "pt", "dpc-published", "dpc", "patch".
const char* estimator_name(Estimator estimator);

/// The estimator of that name; empty for any other name.
std::optional<Estimator> estimator_from_name(const std::string& name);

/// The budget of exact rendering and of measurements, in computation time that is counted from the
/// work done and is the same on all machines; live, that of the rays (docs/performance.md).
enum class Quality {
    draft,   ///< a quarter of the time of `normal`
    normal,  ///< a second of sound in at most about a second of two processors
    fine     ///< no budget: Simulation::kRays rays, and measurements until their errors are small
};

/// The name in scene files and on the command line: "draft", "normal", "fine".
const char* quality_name(Quality quality);

/// The quality of that name; empty for any other name.
std::optional<Quality> quality_from_name(const std::string& name);

/// The settings of the propagation: the "simulation" object of a scene file.
struct Simulation {
    /// Largest number of rays: those of a source in one frame and their results have to fit in
    /// memory.
    static constexpr int kMaxRays = 200'000;
    static constexpr int kRays = 1000;                 ///< rays where none are set
    static constexpr int kMaxOrder = 1'000'000;        ///< largest limit of the reflection order
    static constexpr float kMaxResponseTime_s = 3600;  ///< largest tau
    static constexpr float kMaxLength_m = 1e6F;        ///< largest patch and largest detector
    static constexpr float kMaxFrameRate_hz = 1000;    ///< most propagation frames per second
    static constexpr float kMaxIrLength_s = 10;        ///< longest response
    static constexpr int kMaxThreads = 1024;           ///< most threads for tracing
    static constexpr int kMaxMemory_mb = 1'000'000;    ///< most memory of the caches
    /// Highest order of image sources: the time for those of a frame increases with its square.
    static constexpr int kHighestSpecularOrder = 100;
    /// Highest diffraction order.
    static constexpr int kHighestDiffractionOrder = 4;
    static constexpr float kLowestWaves_hz = 20;    ///< lowest `waves_hz` above 0
    static constexpr float kHighestWaves_hz = 500;  ///< highest `waves_hz`; "auto"

    Estimator estimator = Estimator::patch;  ///< how energy responses are estimated
    /// Rays per source and frame, 1 to kMaxRays; more rays, less noise. If absent: kRays, or in
    /// exact rendering as many up to kRays as `quality` allows.
    std::optional<int> rays;
    Quality quality = Quality::normal;  ///< budget of rendering and of measurements
    int order = 0;                      ///< highest reflection order, up to kMaxOrder; 0: no limit
    /// Highest order of the image sources, 0 to kHighestSpecularOrder. Flutter between two walls
    /// has higher ones, without a limit of `order`, if this is not 0.
    int specular_order = 3;
    bool specular = true;  ///< false omits purely specular paths
    bool direct = true;    ///< false omits the direct sound and its diffraction
    /// Highest number of edges that the direct sound bends around, those of a curved surface, and
    /// both of a face below 5 cm, counting as one: 0 to kHighestDiffractionOrder; 0: no
    /// diffraction.
    int diffraction_order = 2;
    bool transmission = true;  ///< false makes all walls opaque
    /// The frequency below which the modes of the room replace rays, at most, and at most as far as
    /// 180 modes and 1.5 times Schroeder's frequency allow; kLowestWaves_hz to kHighestWaves_hz; 0:
    /// rays alone.
    float waves_hz = kHighestWaves_hz;
    /// tau: the time over which the caches average, 0 to kMaxResponseTime_s. Longer: less noise,
    /// but slower reaction to movement.
    float response_time_s = 0.5F;
    /// lambda: edge length of the patches, above 0, up to kMaxLength_m.
    float patch_size_m = 0.5F;
    /// Radius of the spheres that detect rays at a listener, above 0, up to kMaxLength_m.
    float listener_radius_m = 0.5F;
    float frame_rate_hz = 30;          ///< frames per second, above 0, up to kMaxFrameRate_hz
    std::optional<float> ir_length_s;  ///< length of the responses, above 0, up to kMaxIrLength_s;
                                       ///< if absent: as long as the room sounds
    std::uint64_t seed = 1;            ///< seed of all random numbers
    std::optional<int> threads;        ///< threads for tracing, 1 to kMaxThreads; if absent: all
                                       ///< processors but one
    int memory_mb = 256;               ///< memory of all caches in 10^6 bytes, 1 to kMaxMemory_mb

    /// True if all settings are equal.
    friend bool operator==(const Simulation&, const Simulation&) = default;

    /// `rays`, or kRays.
    int ray_count() const { return rays.value_or(kRays); }

    /// `response_time_s` in frames: F = max(1, round(tau * frame rate)).
    int window_frames() const;

    /// Throws InputError if a value is out of its range.
    void check() const;
};

}  // namespace aula
