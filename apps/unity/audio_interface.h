#pragma once

#include <cstddef>
#include <cstdint>

// The binary interface of Unity's native audio plugins, version 0x010402 (Unity 2018.1 and later),
// as the public header AudioPluginInterface.h describes it. Matrices are stored by columns.

namespace aula::unity {

/// Results of callbacks.
inline constexpr int kOk = 0;
inline constexpr int kUnsupported = 1;

inline constexpr std::uint32_t kApiVersion = 0x010402;

struct EffectState;

/// What a host says of the source at which a spatializer is, and of the listener.
struct SpatializerData {
    float listener[16];  ///< from the world to the listener
    float source[16];    ///< from the source to the world
    float spatial_blend;
    float reverb_zone_mix;
    float spread_deg;
    float stereo_pan;
    /// Attenuation at a distance, by which the host ranks its voices.
    int (*attenuation)(EffectState*, float distance_m, float of_curve, float* result);
    float least_distance_m;
    float greatest_distance_m;
};
static_assert(sizeof(SpatializerData) == 160 && offsetof(SpatializerData, attenuation) == 144);

/// An instance of an effect.
struct EffectState {
    std::uint32_t size;
    std::uint32_t sample_rate_hz;
    std::uint64_t sample;  ///< at the begin of the block
    std::uint64_t sample_before;
    float* side_chain;
    void* effect;  ///< of the plugin
    std::uint32_t flags;
    void* internal;
    SpatializerData* spatializer;
    std::uint32_t block;  ///< samples of each call
    std::uint32_t api_version;
    void* ambisonic;
};
static_assert(sizeof(EffectState) == 80 && offsetof(EffectState, spatializer) == 56);

struct ParameterDefinition {
    char name[16];
    char unit[16];
    const char* description;
    float least;
    float greatest;
    float initial;
    float display_scale;
    float display_exponent;
};
static_assert(sizeof(ParameterDefinition) == 64);

/// Flags of a definition.
inline constexpr std::uint64_t kIsSpatializer = 1 << 1;
inline constexpr std::uint64_t kAppliesDistance = 1 << 3;
inline constexpr std::uint64_t kNeedsSpatializerData = 1 << 4;

struct EffectDefinition {
    std::uint32_t size;
    std::uint32_t parameter_size;
    std::uint32_t api_version;
    std::uint32_t version;
    std::uint32_t channels;  ///< 0: as many as the host has
    std::uint32_t parameters;
    std::uint64_t flags;
    char name[32];
    int (*create)(EffectState*);
    int (*release)(EffectState*);
    int (*reset)(EffectState*);
    int (*process)(EffectState*, float* in, float* out, unsigned samples, int in_channels,
                   int out_channels);
    int (*set_position)(EffectState*, unsigned position);
    ParameterDefinition* parameter_definitions;
    int (*set_parameter)(EffectState*, int index, float value);
    int (*get_parameter)(EffectState*, int index, float* value, char* text);
    int (*get_buffer)(EffectState*, const char* name, float* buffer, int samples);
};
static_assert(sizeof(EffectDefinition) == 136 && offsetof(EffectDefinition, create) == 64);

}  // namespace aula::unity
