#include <algorithm>
#include <cmath>
#include <exception>

#include "apps/unity/effects.h"
#include "apps/unity/room_player.h"

namespace aula::unity {
namespace {

constexpr std::uint32_t kFirstWithSpatializers = 0x010300;
constexpr int kParameters = 2;

ParameterDefinition parameters[kParameters] = {
    {"Gain", "dB", "0 dB: 1.0 is a sound pressure of 1.0 at a distance of 1 m", -80, 40, 0, 1, 1},
    {"Directivity", "",
     "0: omni, 1: subcardioid, 2: cardioid, 3: supercardioid, 4: figure of eight, 5: talker, "
     "6: loudspeaker",
     0, 6, 0, 1, 1}};

SourceSlot& slot_of(const EffectState* state) { return *static_cast<SourceSlot*>(state->effect); }

bool has_spatializer_data(const EffectState* state) {
    return state->size >= sizeof(EffectState) && state->api_version >= kFirstWithSpatializers &&
           state->spatializer != nullptr;
}

/// Louder sources are audible, as the host ranks them.
int attenuate(EffectState*, float distance_m, float, float* result) {
    *result = 1 / std::max(1.0F, distance_m);
    return kOk;
}

int create(EffectState* state) {
    try {
        state->effect = RoomPlayer::get().take_slot();
    } catch (const std::exception&) {
        state->effect = nullptr;
    }
    if (state->effect == nullptr) return kUnsupported;
    if (has_spatializer_data(state)) state->spatializer->attenuation = attenuate;
    return kOk;
}

int release(EffectState* state) {
    if (state->effect != nullptr) RoomPlayer::get().give_back(slot_of(state));
    state->effect = nullptr;
    return kOk;
}

int process(EffectState* state, float* in, float* out, unsigned length, int in_channels,
            int out_channels) {
    const auto samples = static_cast<int>(length);
    RoomPlayer& player = RoomPlayer::get();
    float share = 0;  // of the sound in the room
    if (state->effect != nullptr && has_spatializer_data(state) && player.is_heard() &&
        samples <= SourceSlot::kMostSamples && in_channels > 0) {
        const SpatializerData& data = *state->spatializer;
        SourceSlot& slot = slot_of(state);
        share = std::clamp(data.spatial_blend, 0.0F, 1.0F);
        slot.matrix.store(data.source);
        player.listener.store(data.listener);
        slot.put(in, samples, in_channels, share);
    }
    for (int n = 0; n < samples; ++n)
        for (int c = 0; c < out_channels; ++c)
            out[n * out_channels + c] = c < in_channels ? (1 - share) * in[n * in_channels + c] : 0;
    return kOk;
}

int set_parameter(EffectState* state, int index, float value) {
    if (state->effect == nullptr || index < 0 || index >= kParameters || std::isnan(value))
        return kUnsupported;
    const ParameterDefinition& range = parameters[index];
    value = std::clamp(value, range.least, range.greatest);
    if (index == static_cast<int>(Parameter::gain_db))
        slot_of(state).gain_db = value;
    else
        slot_of(state).directivity = static_cast<int>(std::lround(value));
    return kOk;
}

int get_parameter(EffectState* state, int index, float* value, char* text) {
    if (state->effect == nullptr || index < 0 || index >= kParameters) return kUnsupported;
    const SourceSlot& slot = slot_of(state);
    if (value != nullptr)
        *value = index == static_cast<int>(Parameter::gain_db)
                     ? slot.gain_db.load()
                     : static_cast<float>(slot.directivity.load());
    if (text != nullptr) *text = 0;
    return kOk;
}

}  // namespace

EffectDefinition spatializer() {
    EffectDefinition definition{};
    definition.size = sizeof definition;
    definition.parameter_size = sizeof(ParameterDefinition);
    definition.api_version = kApiVersion;
    definition.version = 1;
    definition.parameters = kParameters;
    definition.flags = kIsSpatializer | kAppliesDistance;
    std::copy_n("Aula Spatializer", sizeof "Aula Spatializer", definition.name);
    definition.create = create;
    definition.release = release;
    definition.process = process;
    definition.parameter_definitions = parameters;
    definition.set_parameter = set_parameter;
    definition.get_parameter = get_parameter;
    return definition;
}

}  // namespace aula::unity
