// The editor of the LV2 plugins: it has their ports and messages through the host.

#include <lv2/atom/forge.h>
#include <lv2/atom/util.h>
#include <lv2/patch/patch.h>
#include <lv2/ui/ui.h>
#include <lv2/urid/urid.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <exception>
#include <iostream>
#include <memory>
#include <string>
#include <string_view>

#include "apps/plugin/editor/plugin_editor.h"
#include "apps/plugin/lv2/features.h"
#include "apps/plugin/lv2/ports.h"

namespace {

using namespace aula::plugin;

class Lv2Editor final : public EditorHost {
 public:
    struct Write {
        LV2UI_Write_Function function;
        LV2UI_Controller controller;
    };

    /// Throws Failure.
    Lv2Editor(const Kind& layout, const char* bundle, Write write, const LV2_URID_Map& map,
              const LV2UI_Touch* touch)
        : layout_(layout),
          folder_(bundle),
          write_(write),
          touch_(touch),
          map_(map),
          values_(initial_values()),
          editor_(*this) {
        lv2_atom_forge_init(&forge_, &map_);
        for (std::size_t p = 0; p < kProperties; ++p) properties_[p] = urid(kPropertyUris[p]);
    }

    PluginEditor& editor() { return editor_; }

    /// Asks the plugin for its properties.
    void ask() {
        std::array<std::uint8_t, 64> buffer;
        lv2_atom_forge_set_buffer(&forge_, buffer.data(), buffer.size());
        LV2_Atom_Forge_Frame frame;
        lv2_atom_forge_object(&forge_, &frame, 0, urid(LV2_PATCH__Get));
        lv2_atom_forge_pop(&forge_, &frame);
        send(buffer.data());
    }

    void receive(std::uint32_t port, std::uint32_t size, std::uint32_t format, const void* data) {
        if (format == 0 && size == sizeof(float)) {
            float value = 0;
            std::memcpy(&value, data, sizeof value);
            receive_value(port, value);
        } else if (format == urid(LV2_ATOM__eventTransfer) && port == notify_port(layout_.output)) {
            receive_message(*static_cast<const LV2_Atom*>(data));
        }
    }

    std::size_t sources() const override { return layout_.sources; }
    std::filesystem::path folder() const override { return folder_; }
    ControlValues values() const override { return values_; }
    RoomFiles files() const override {
        return {.scene = texts_[static_cast<std::size_t>(Property::scene)], .hrtf = {}};
    }
    float level_db() const override { return level_db_; }
    std::string status() const override {
        return texts_[static_cast<std::size_t>(Property::status)];
    }
    void begin_change(Control control) override { touch(control, true); }
    void end_change(Control control) override { touch(control, false); }
    void change(Control control, float value) override {
        values_[static_cast<std::size_t>(control)] = value;
        write_.function(write_.controller, port_of(control), sizeof value, 0, &value);
    }
    void choose_scene(const std::filesystem::path& file) override {
        const std::string path = file.string();
        std::array<std::uint8_t, Message::kLongest + 256> buffer;
        if (path.size() > Message::kLongest) return;
        lv2_atom_forge_set_buffer(&forge_, buffer.data(), buffer.size());
        LV2_Atom_Forge_Frame frame;
        lv2_atom_forge_object(&forge_, &frame, 0, urid(LV2_PATCH__Set));
        lv2_atom_forge_key(&forge_, urid(LV2_PATCH__property));
        lv2_atom_forge_urid(&forge_, properties_[static_cast<std::size_t>(Property::scene)]);
        lv2_atom_forge_key(&forge_, urid(LV2_PATCH__value));
        lv2_atom_forge_path(&forge_, path.c_str(), static_cast<std::uint32_t>(path.size() + 1));
        lv2_atom_forge_pop(&forge_, &frame);
        send(buffer.data());
    }

 private:
    LV2_URID urid(const char* uri) const { return map_.map(map_.handle, uri); }

    std::uint32_t port_of(Control control) const {
        return control_port(layout_.output, static_cast<std::size_t>(control));
    }

    void touch(Control control, bool grabbed) const {
        if (touch_ != nullptr) touch_->touch(touch_->handle, port_of(control), grabbed);
    }

    void send(const std::uint8_t* buffer) const {
        const auto& atom = *reinterpret_cast<const LV2_Atom*>(buffer);
        write_.function(write_.controller, messages_port(layout_.output),
                        lv2_atom_total_size(&atom), urid(LV2_ATOM__eventTransfer), buffer);
    }

    void receive_value(std::uint32_t port, float value) {
        if (port == level_port(layout_.output)) level_db_ = value;
        for (std::size_t i = 0; i < kControls; ++i)
            if (port == control_port(layout_.output, i))
                values_[i] = valid(static_cast<Control>(i), value);
    }

    void receive_message(const LV2_Atom& atom) {
        if (atom.type != urid(LV2_ATOM__Object) && atom.type != urid(LV2_ATOM__Blank)) return;
        const auto& object = reinterpret_cast<const LV2_Atom_Object&>(atom);
        if (object.body.otype != urid(LV2_PATCH__Set)) return;
        const LV2_Atom* property = nullptr;
        const LV2_Atom* value = nullptr;
        lv2_atom_object_get(&object, urid(LV2_PATCH__property), &property, urid(LV2_PATCH__value),
                            &value, 0);
        if (property == nullptr || property->type != urid(LV2_ATOM__URID) || value == nullptr)
            return;
        if (value->type != urid(LV2_ATOM__Path) && value->type != urid(LV2_ATOM__String)) return;
        const LV2_URID name = reinterpret_cast<const LV2_Atom_URID*>(property)->body;
        for (std::size_t p = 0; p < kProperties; ++p) {
            if (name != properties_[p]) continue;
            const auto* const text = static_cast<const char*>(LV2_ATOM_BODY_CONST(value));
            texts_[p] = std::string(text, strnlen(text, value->size));
        }
    }

    const Kind& layout_;
    const std::filesystem::path folder_;
    const Write write_;
    const LV2UI_Touch* const touch_;
    LV2_URID_Map map_;
    LV2_Atom_Forge forge_{};
    std::array<LV2_URID, kProperties> properties_{};
    ControlValues values_;
    float level_db_ = -120;
    std::array<std::string, kProperties> texts_;
    PluginEditor editor_;
};

Lv2Editor& editor_of(LV2UI_Handle handle) { return *static_cast<Lv2Editor*>(handle); }

LV2UI_Handle instantiate(const LV2UI_Descriptor*, const char* plugin, const char* bundle,
                         LV2UI_Write_Function write, LV2UI_Controller controller,
                         LV2UI_Widget* widget, const LV2_Feature* const* features) {
    const auto* const uri =
        std::find_if(kPluginUris.begin(), kPluginUris.end(),
                     [&](const char* u) { return std::string_view(u) == plugin; });
    const auto* const map = static_cast<const LV2_URID_Map*>(find_feature(features, LV2_URID__map));
    void* const parent = find_feature(features, LV2_UI__parent);
    if (uri == kPluginUris.end() || map == nullptr || parent == nullptr) return nullptr;
    try {
        auto editor = std::make_unique<Lv2Editor>(
            kLayouts[static_cast<std::size_t>(uri - kPluginUris.begin())], bundle,
            Lv2Editor::Write{write, controller}, *map,
            static_cast<const LV2UI_Touch*>(find_feature(features, LV2_UI__touch)));
        editor->editor().open(reinterpret_cast<std::uintptr_t>(parent));
        editor->editor().show();
        editor->ask();
        const auto* const resize =
            static_cast<const LV2UI_Resize*>(find_feature(features, LV2_UI__resize));
        const EditorSize size = editor->editor().size();
        if (resize != nullptr)
            resize->ui_resize(resize->handle, static_cast<int>(size.width),
                              static_cast<int>(size.height));
        *widget = reinterpret_cast<LV2UI_Widget>(editor->editor().window());
        return editor.release();
    } catch (const std::exception& error) {
        // A host shows no other text of an editor.
        std::cerr << "aula: " << error.what() << '\n';
        return nullptr;
    }
}

void cleanup(LV2UI_Handle handle) { delete &editor_of(handle); }

void port_event(LV2UI_Handle handle, std::uint32_t port, std::uint32_t size, std::uint32_t format,
                const void* data) {
    editor_of(handle).receive(port, size, format, data);
}

const void* extension_data(const char* uri) {
    static const LV2UI_Idle_Interface kIdle{[](LV2UI_Handle handle) {
        editor_of(handle).editor().idle();
        return 0;
    }};
    return std::strcmp(uri, LV2_UI__idleInterface) == 0 ? &kIdle : nullptr;
}

constexpr LV2UI_Descriptor kDescriptor{kEditorUri, instantiate, cleanup, port_event,
                                       extension_data};

}  // namespace

LV2_SYMBOL_EXPORT const LV2UI_Descriptor* lv2ui_descriptor(std::uint32_t index) {
    return index == 0 ? &kDescriptor : nullptr;
}
