#pragma once

#include <dlfcn.h>
#include <lv2/ui/ui.h>
#include <lv2/urid/urid.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <vector>

#include "apps/plugin/lv2/ports.h"
#include "tests/plugin/channels.h"
#include "tests/plugin/editor/editor_format.h"

namespace aula::test {

/// The host has the values of the ports, which a plugin would read.
class Lv2EditorHost final : public EditorFormat {
 public:
    Lv2EditorHost() {
        for (std::size_t i = 0; i < plugin::kControls; ++i)
            values_[i] = plugin::control_infos()[i].initial;
    }
    ~Lv2EditorHost() override { close(); }

    bool open(std::uintptr_t parent) override {
        void* const library = dlopen(AULA_LV2_EDITOR, RTLD_NOW);
        demand(library != nullptr, "no editor");
        const auto find =
            reinterpret_cast<LV2UI_DescriptorFunction>(dlsym(library, "lv2ui_descriptor"));
        demand(find != nullptr, "no lv2ui_descriptor");
        descriptor_ = find(0);
        LV2_URID_Map map{this, map_uri};
        LV2UI_Touch touch{this, [](LV2UI_Feature_Handle self, std::uint32_t, bool grabbed) {
                              auto& host = *static_cast<Lv2EditorHost*>(self);
                              ++(grabbed ? host.begun_ : host.ended_);
                          }};
        touch_ = touch;
        map_ = map;
        const LV2_Feature features[] = {{LV2_URID__map, &map_},
                                        {LV2_UI__parent, reinterpret_cast<void*>(parent)},
                                        {LV2_UI__touch, &touch_}};
        const LV2_Feature* const list[] = {&features[0], &features[1], &features[2], nullptr};
        LV2UI_Widget widget = nullptr;
        handle_ = descriptor_->instantiate(descriptor_, plugin::kPluginUris[0], AULA_LV2_BUNDLE,
                                           write, this, &widget, list);
        return handle_ != nullptr && widget != nullptr;
    }
    void idle() override {
        const auto* const idle = static_cast<const LV2UI_Idle_Interface*>(
            descriptor_->extension_data(LV2_UI__idleInterface));
        idle->idle(handle_);
    }
    void close() override {
        if (handle_ != nullptr) descriptor_->cleanup(std::exchange(handle_, nullptr));
    }
    double get(plugin::Control control) const override {
        return static_cast<double>(values_[static_cast<std::size_t>(control)]);
    }
    void set(plugin::Control control, double value) override {
        const auto i = static_cast<std::size_t>(control);
        values_[i] = static_cast<float>(value);
        descriptor_->port_event(handle_, plugin::control_port(OutputFormat::binaural, i),
                                sizeof(float), 0, &values_[i]);
    }
    double told(plugin::Control control) const override { return get(control); }
    int gestures() const override { return begun_ - ended_; }
    int ended_gestures() const override { return ended_; }

 private:
    static LV2_URID map_uri(LV2_URID_Map_Handle self, const char* uri) {
        std::vector<std::string>& uris = static_cast<Lv2EditorHost*>(self)->uris_;
        const auto at = std::find(uris.begin(), uris.end(), uri);
        const auto index = static_cast<LV2_URID>(at - uris.begin());
        if (at == uris.end()) uris.emplace_back(uri);
        return index + 1;
    }
    static void write(LV2UI_Controller self, std::uint32_t port, std::uint32_t size,
                      std::uint32_t format, const void* data) {
        auto& host = *static_cast<Lv2EditorHost*>(self);
        for (std::size_t i = 0; i < plugin::kControls; ++i)
            if (format == 0 && size == sizeof(float) &&
                port == plugin::control_port(OutputFormat::binaural, i))
                std::memcpy(&host.values_[i], data, sizeof(float));
    }

    const LV2UI_Descriptor* descriptor_ = nullptr;
    LV2UI_Handle handle_ = nullptr;
    LV2_URID_Map map_{};
    LV2UI_Touch touch_{};
    std::vector<std::string> uris_;
    plugin::ControlValues values_{};
    int begun_ = 0;
    int ended_ = 0;
};

}  // namespace aula::test
