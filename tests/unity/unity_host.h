#pragma once

#include <aula.h>

#include <array>
#include <string>
#include <vector>

#include "apps/unity/audio_interface.h"
#include "tests/plugin/channels.h"
#include "tests/plugin/shared_library.h"

namespace aula::test {

/// A vector of the engine: x to the right, y up, z to the front.
using UnityVector = std::array<float, 3>;

/// Where something of the engine is, and in which direction its front and its right are.
struct UnityTransform {
    UnityVector position{};
    UnityVector right{1, 0, 0};
    UnityVector front{0, 0, 1};
};

/// The built plugin, as the engine loads it. It exports the functions of aula.h, too.
class UnityPlugin {
 public:
    static const UnityPlugin& get();

    const unity::EffectDefinition& effect(const std::string& name) const;
    template <typename Function>
    Function* find(const char* name) const {
        Function* const function = library_.find<Function*>(name);
        demand(function != nullptr, name);
        return function;
    }

    int (*prepare)();
    void (*play)(aula_room*);
    int (*is_heard)();
    int (*take_problem)(char*, int);
    decltype(aula_message)* message;
    decltype(aula_scene_create)* scene_create;
    decltype(aula_scene_destroy)* scene_destroy;
    decltype(aula_scene_add_object)* scene_add_object;
    decltype(aula_scene_add_source)* scene_add_source;
    decltype(aula_scene_set_listener)* scene_set_listener;
    decltype(aula_room_create)* room_create;
    decltype(aula_room_destroy)* room_destroy;
    decltype(aula_room_process)* room_process;
    decltype(aula_room_status)* room_status;

 private:
    UnityPlugin();

    SharedLibrary library_;
    std::vector<const unity::EffectDefinition*> effects_;
};

/// An instance of an effect, with the matrices that the engine gives it.
class UnityEffect {
 public:
    UnityEffect(const std::string& name, unsigned sample_rate_hz, unsigned block);
    ~UnityEffect();
    UnityEffect(const UnityEffect&) = delete;
    UnityEffect& operator=(const UnityEffect&) = delete;

    void place(const UnityTransform& source, const UnityTransform& listener);
    int set(int parameter, float value) {
        return definition_.set_parameter(&state_, parameter, value);
    }
    int get(int parameter, float& value) {
        return definition_.get_parameter(&state_, parameter, &value, nullptr);
    }

    /// A block of interleaved samples.
    std::vector<float> process(std::vector<float> in, int in_channels, int out_channels);

    unity::SpatializerData data{};

 private:
    const unity::EffectDefinition& definition_;
    unity::EffectState state_{};
};

}  // namespace aula::test
