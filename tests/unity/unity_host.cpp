#include "tests/unity/unity_host.h"

#include <algorithm>
#include <utility>

#include "tests/support/realtime_trap.h"

namespace aula::test {

namespace {

/// By columns: what leads from something to the world.
void write_matrix(float (&matrix)[16], const UnityTransform& to) {
    // In left-handed axes up is front x right.
    const auto& [f, r] = std::pair(to.front, to.right);
    const UnityVector up{f[1] * r[2] - f[2] * r[1], f[2] * r[0] - f[0] * r[2],
                         f[0] * r[1] - f[1] * r[0]};
    const UnityVector columns[] = {to.right, up, to.front, to.position};
    for (std::size_t c = 0; c < 4; ++c) {
        std::copy_n(columns[c].begin(), 3, matrix + 4 * c);
        matrix[4 * c + 3] = c == 3 ? 1 : 0;
    }
}

/// The inverse of a matrix that only turns and moves.
void invert(float (&matrix)[16]) {
    float inverse[16]{};
    for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t c = 0; c < 3; ++c) {
            inverse[4 * c + r] = matrix[4 * r + c];
            inverse[12 + r] -= matrix[4 * r + c] * matrix[12 + c];
        }
    inverse[15] = 1;
    std::copy_n(inverse, 16, matrix);
}

}  // namespace

const UnityPlugin& UnityPlugin::get() {
    static const UnityPlugin plugin;
    return plugin;
}

UnityPlugin::UnityPlugin() : library_(AULA_UNITY_BINARY) {
    prepare = find<int()>("aula_unity_prepare");
    demand(prepare() == AULA_OK, "a library is missing");
    play = find<void(aula_room*)>("aula_unity_play");
    is_heard = find<int()>("aula_unity_is_heard");
    take_problem = find<int(char*, int)>("aula_unity_take_problem");
    message = find<decltype(aula_message)>("aula_message");
    scene_create = find<decltype(aula_scene_create)>("aula_scene_create");
    scene_destroy = find<decltype(aula_scene_destroy)>("aula_scene_destroy");
    scene_add_object = find<decltype(aula_scene_add_object)>("aula_scene_add_object");
    scene_add_source = find<decltype(aula_scene_add_source)>("aula_scene_add_source");
    scene_set_listener = find<decltype(aula_scene_set_listener)>("aula_scene_set_listener");
    room_create = find<decltype(aula_room_create)>("aula_room_create");
    room_destroy = find<decltype(aula_room_destroy)>("aula_room_destroy");
    room_process = find<decltype(aula_room_process)>("aula_room_process");
    room_status = find<decltype(aula_room_status)>("aula_room_status");
    unity::EffectDefinition** definitions = nullptr;
    const int count =
        find<int(unity::EffectDefinition***)>("UnityGetAudioEffectDefinitions")(&definitions);
    effects_.assign(definitions, definitions + count);
}

const unity::EffectDefinition& UnityPlugin::effect(const std::string& name) const {
    const auto found = std::find_if(effects_.begin(), effects_.end(),
                                    [&](const auto* effect) { return name == effect->name; });
    demand(found != effects_.end(), "no effect of this name");
    return **found;
}

UnityEffect::UnityEffect(const std::string& name, unsigned sample_rate_hz, unsigned block)
    : definition_(UnityPlugin::get().effect(name)) {
    data.spatial_blend = 1;
    place({}, {});
    state_.size = sizeof state_;
    state_.sample_rate_hz = sample_rate_hz;
    state_.block = block;
    state_.api_version = unity::kApiVersion;
    state_.spatializer = &data;
    demand(definition_.create(&state_) == unity::kOk, "no instance");
}

UnityEffect::~UnityEffect() { definition_.release(&state_); }

void UnityEffect::place(const UnityTransform& source, const UnityTransform& listener) {
    write_matrix(data.source, source);
    write_matrix(data.listener, listener);
    invert(data.listener);
}

std::vector<float> UnityEffect::process(std::vector<float> in, int in_channels, int out_channels) {
    const std::size_t samples = in.size() / static_cast<std::size_t>(in_channels);
    std::vector<float> out(samples * static_cast<std::size_t>(out_channels), -1);
    RealtimeViolations violations;
    {
        const RealtimeTrap trap;
        definition_.process(&state_, in.data(), out.data(), static_cast<unsigned>(samples),
                            in_channels, out_channels);
        violations = trap.violations();
    }
    demand(violations.total() == 0, "process() allocates, frees, locks or writes");
    state_.sample += samples;
    return out;
}

}  // namespace aula::test
