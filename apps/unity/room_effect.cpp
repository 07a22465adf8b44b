#include <algorithm>
#include <array>
#include <new>

#include "apps/unity/effects.h"
#include "apps/unity/room_player.h"

namespace aula::unity {
namespace {

using Channel = std::array<float, SourceSlot::kMostSamples>;

/// The ears of an instance.
struct Ears {
    Channel left{}, right{};
};

int create_room(EffectState* state) {
    state->effect = new (std::nothrow) Ears;
    return state->effect != nullptr ? kOk : kUnsupported;
}

int release_room(EffectState* state) {
    RoomPlayer::get().resign(state->effect);
    delete static_cast<Ears*>(state->effect);
    state->effect = nullptr;
    return kOk;
}

int process_room(EffectState* state, float* in, float* out, unsigned length, int in_channels,
                 int out_channels) {
    const auto samples = static_cast<int>(length);
    for (int n = 0; n < samples; ++n)
        for (int c = 0; c < out_channels; ++c)
            out[n * out_channels + c] = c < in_channels ? in[n * in_channels + c] : 0;
    RoomPlayer& player = RoomPlayer::get();
    auto* const ears = static_cast<Ears*>(state->effect);
    if (ears == nullptr || samples > SourceSlot::kMostSamples || !player.claims(ears)) return kOk;
    const bool has_listener = state->size >= sizeof(EffectState) &&
                              state->api_version >= kApiVersion && state->spatializer != nullptr;
    if (has_listener) player.listener.store(state->spatializer->listener);
    if (!player.render(ears->left.data(), ears->right.data(), samples)) return kOk;
    for (int n = 0; n < samples; ++n) {
        const float left = ears->left[static_cast<std::size_t>(n)];
        const float right = ears->right[static_cast<std::size_t>(n)];
        float* const sample = out + n * out_channels;
        if (out_channels == 1) sample[0] += (left + right) / 2;
        if (out_channels < 2) continue;
        sample[0] += left;
        sample[1] += right;
    }
    return kOk;
}

}  // namespace

EffectDefinition room_effect() {
    EffectDefinition definition{};
    definition.size = sizeof definition;
    definition.parameter_size = sizeof(ParameterDefinition);
    definition.api_version = kApiVersion;
    definition.version = 1;
    definition.flags = kNeedsSpatializerData;
    std::copy_n("Aula Room", sizeof "Aula Room", definition.name);
    definition.create = create_room;
    definition.release = release_room;
    definition.process = process_room;
    return definition;
}

}  // namespace aula::unity
