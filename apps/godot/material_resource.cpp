#include "apps/godot/material_resource.h"

#include <string_view>
#include <utility>

namespace aula::godot {
namespace {

Value packed(const std::vector<float>& values) {
    // A PackedFloat32Array is constructed of an Array, which grows by append().
    Value array;
    GDExtensionCallError error{};
    api.variant_construct(GDEXTENSION_VARIANT_TYPE_ARRAY,
                          const_cast<GDExtensionVariantPtr>(array.data()), nullptr, 0, &error);
    for (const float value : values) array.call("append", static_cast<double>(value));
    Value result;
    const GDExtensionConstVariantPtr argument = array.data();
    api.variant_construct(GDEXTENSION_VARIANT_TYPE_PACKED_FLOAT32_ARRAY,
                          const_cast<GDExtensionVariantPtr>(result.data()), &argument, 1, &error);
    return result;
}

void add_values(ClassEntry& entry, const char* name, std::vector<float> MaterialResource::*values) {
    entry.add_property(
        {.name = name, .type = GDEXTENSION_VARIANT_TYPE_PACKED_FLOAT32_ARRAY},
        [values](Instance& self, const Value*) {
            return packed(static_cast<MaterialResource&>(self).*values);
        },
        [values](Instance& self, const Value* arguments) {
            static_cast<MaterialResource&>(self).*values = arguments[0].to_floats();
            return Value();
        });
}

}  // namespace

bool is_preset(const std::string& name) {
    return !name.empty() && name.find(',') == std::string::npos &&
           ("," + std::string(kPresetNames) + ",").find("," + name + ",") != std::string::npos;
}

std::string MaterialResource::name() const {
    return preset.empty() ? "AulaMaterial " + std::to_string(object().id()) : preset;
}

std::unique_ptr<ClassEntry> register_material() {
    auto entry = std::make_unique<ClassEntry>(
        "AulaMaterial", "Resource",
        [](Object object) -> Instance* { return new MaterialResource(object); }, false, true);
    entry->add_property({.name = "preset",
                         .type = GDEXTENSION_VARIANT_TYPE_STRING,
                         .hint = 3,  // PROPERTY_HINT_ENUM_SUGGESTION
                         .hint_string = kPresetNames},
                        method_of<MaterialResource>([](MaterialResource& self, const Value*) {
                            return Value(self.preset);
                        }),
                        method_of<MaterialResource>([](MaterialResource& self, const Value* a) {
                            self.preset = a[0].to_string();
                            return Value();
                        }));
    add_values(*entry, "absorption", &MaterialResource::absorption);
    add_values(*entry, "scattering", &MaterialResource::scattering);
    add_values(*entry, "sound_reduction_db", &MaterialResource::sound_reduction_db);
    return entry;
}

ValueInfo material_property(const char* name) {
    return {.name = name,
            .type = GDEXTENSION_VARIANT_TYPE_OBJECT,
            .class_name = "AulaMaterial",
            .hint = 17,  // PROPERTY_HINT_RESOURCE_TYPE
            .hint_string = "AulaMaterial"};
}

}  // namespace aula::godot
