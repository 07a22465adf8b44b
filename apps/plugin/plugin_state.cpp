#include "apps/plugin/plugin_state.h"

#include <nlohmann/json.hpp>

#include "process/files.h"

namespace aula::plugin {

namespace {

using Json = nlohmann::json;

/// The number of the format, without which a text is no state.
constexpr const char* kFormat = "aula_room";

/// An object, also of a text that is none.
Json object_of(std::string_view text) {
    Json json = Json::parse(text, nullptr, false);
    return json.is_object() ? json : Json::object();
}

/// A member's text; empty if there is none.
std::string text_of(const Json& json, const char* name) {
    const auto at = json.find(name);
    return at != json.end() && at->is_string() ? at->get<std::string>() : std::string();
}

}  // namespace

std::string write_state(const PluginState& state) {
    Json json = object_of(state.read_from);
    json[kFormat] = 1;
    json["scene"] = state.files.scene.string();
    json["hrtf"] = state.files.hrtf.string();
    json.erase("seed");
    if (state.files.seed) json["seed"] = *state.files.seed;
    Json& controls = json["controls"];
    if (!controls.is_object()) controls = Json::object();
    for (std::size_t i = 0; i < kControls; ++i)
        controls[control_infos()[i].symbol] = state.controls[i];
    // A path that is not UTF-8 loses the bytes that are not.
    return json.dump(1, ' ', false, Json::error_handler_t::replace);
}

std::optional<PluginState> read_state(std::string_view text) {
    const Json json = object_of(text);
    if (!json.contains(kFormat)) return std::nullopt;
    PluginState state;
    state.read_from = text;
    state.files.scene = utf8_path(text_of(json, "scene"));
    state.files.hrtf = utf8_path(text_of(json, "hrtf"));
    if (const auto seed = json.find("seed"); seed != json.end() && seed->is_number_unsigned())
        state.files.seed = seed->get<std::uint64_t>();
    const auto controls = json.find("controls");
    for (std::size_t i = 0; i < kControls && controls != json.end() && controls->is_object(); ++i) {
        const auto value = controls->find(control_infos()[i].symbol);
        if (value != controls->end() && value->is_number())
            state.controls[i] = valid(static_cast<Control>(i), value->get<float>());
    }
    return state;
}

}  // namespace aula::plugin
