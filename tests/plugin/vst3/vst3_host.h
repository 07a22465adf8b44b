#pragma once

#include <travesty/audio_processor.h>
#include <travesty/component.h>
#include <travesty/edit_controller.h>

#include <string>
#include <vector>

#include "apps/plugin/controls.h"
#include "tests/plugin/channels.h"

namespace aula::test {

/// A change of a parameter, from 0 to 1, at a sample of a signal.
struct Vst3Change {
    std::size_t sample;
    plugin::Control control;
    double value;
};

/// A host of the built module: an instance of the class of a name.
class Vst3Host {
 public:
    explicit Vst3Host(const std::string& name);
    ~Vst3Host();
    Vst3Host(const Vst3Host&) = delete;
    Vst3Host& operator=(const Vst3Host&) = delete;

    v3_component** component() const { return component_; }
    v3_audio_processor** processor() const { return processor_; }
    v3_edit_controller** controller() const { return controller_; }

    v3_result set_up(bool is_offline, double rate_hz = 48000) const;
    v3_result set_active(bool is_active) const {
        return v3_cpp_obj(component_)->set_active(component_, is_active ? 1 : 0);
    }

    /// Processes a signal in blocks of a size, or one of no samples; the last one has the later
    /// changes. No channels if the plugin refuses.
    Channels run(const Channels& input, std::size_t size,
                 const std::vector<Vst3Change>& changes = {}) const;

    /// State in parts of 7 bytes; empty if it cannot be saved.
    std::string save() const;
    bool load(const std::string& state) const;

 private:
    v3_component** component_ = nullptr;
    v3_audio_processor** processor_ = nullptr;
    v3_edit_controller** controller_ = nullptr;
};

}  // namespace aula::test
