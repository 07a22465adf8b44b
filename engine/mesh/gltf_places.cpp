#include "engine/mesh/gltf_places.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "engine/input/place_guess.h"
#include "engine/mesh/gltf_accessors.h"
#include "engine/mesh/gltf_json.h"
#include "process/files.h"

namespace aula {

namespace {

constexpr NumberRange kGain{0, 1e6, true, "a gain from 0 to 1e6"};

double gain_of(const JsonReader& json) {
    const auto gain = json.find("gain");
    return gain ? gain->number(kGain) : 1;
}

std::string name_of(const JsonReader& node) {
    const auto name = node.find("name");
    return name ? name->string("a name") : "";
}

/// A place at a node that looks along an axis of it.
ImportedPlace place_at(ImportedPlace::Kind kind, std::string name, const glm::dmat4& transform,
                       const glm::dvec4& axis) {
    ImportedPlace place;
    place.kind = kind;
    place.name = std::move(name);
    place.position = Vec3(transform[3]);
    place.front = Vec3(transform * axis);
    return place;
}

}  // namespace

GltfPlaces::GltfPlaces(const JsonReader& root) {
    const auto audio = gltf_extension(root, kGltfAudio);
    if (!audio) return;
    emitters_ = gltf_list(*audio, "emitters");
    sources_ = gltf_list(*audio, "sources");
    sounds_ = gltf_list(*audio, "audio");
}

void GltfPlaces::add(const JsonReader& node, const glm::dmat4& transform) {
    // "The front of a glTF asset faces the positive Z axis", a camera looks along the negative one
    // (glTF 2.0, 3.4 and 3.10.2).
    const glm::dvec4 front(0, 0, 1, 0);
    const std::string name = name_of(node);
    if (add_emitter(node, place_at(ImportedPlace::Kind::source, name, transform, front))) return;
    if (node.find("camera")) {
        cameras_.push_back(place_at(ImportedPlace::Kind::listener, name, transform, -front));
        return;
    }
    if (node.find("mesh")) {
        if (const auto shape = guess_place(name); shape && !shape->is_listener)
            shapes_of_sources_.push_back(name);
        return;
    }
    std::string lower = name;
    std::transform(lower.begin(), lower.end(), lower.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const bool is_said = lower.starts_with("source") || lower.starts_with("speaker") ||
                         lower.starts_with("listener");
    if (!is_said && gltf_extension(node, "KHR_lights_punctual")) return;  // "Light source"
    const auto guess = guess_place(name);
    if (!guess) return;
    using Kind = ImportedPlace::Kind;
    places_.push_back(
        place_at(guess->is_listener ? Kind::listener : Kind::source, name, transform, front));
    if (!is_said) places_.back().guessed_by = guess->word;
}

std::vector<ImportedPlace> GltfPlaces::take() {
    places_.insert(places_.end(), cameras_.begin(), cameras_.end());
    return std::move(places_);
}

/// Returns whether the node has an emitter with a place.
bool GltfPlaces::add_emitter(const JsonReader& node, ImportedPlace place) {
    const auto of_node = gltf_extension(node, kGltfAudio);
    const auto reference = of_node ? of_node->find("emitter") : std::nullopt;
    if (!reference) return false;
    const JsonReader& emitter = emitters_[gltf_index(*reference, emitters_.size(), "emitters")];
    if (const auto type = emitter.find("type"); type && !type->is_text("positional")) return false;
    if (place.name.empty()) place.name = name_of(emitter);
    place.gain = gain_of(emitter);
    // A source of Aula plays one sound.
    const std::vector<JsonReader> sources = gltf_list(emitter, "sources");
    for (const JsonReader& source : sources) {
        ImportedPlace sounding = place;
        read_sound(sources_[gltf_index(source, sources_.size(), "sources")], sounding);
        places_.push_back(std::move(sounding));
    }
    if (sources.empty()) places_.push_back(std::move(place));
    return true;
}

void GltfPlaces::read_sound(const JsonReader& source, ImportedPlace& place) const {
    place.gain *= gain_of(source);
    if (const auto loop = source.find("loop")) place.loop = loop->boolean();
    const auto reference = source.find("audio");
    if (!reference) return;
    const std::size_t number = gltf_index(*reference, sounds_.size(), "sounds");
    const auto uri = sounds_[number].find("uri");
    // A data URI may be long, and have many sources: it is not copied.
    const auto* const written = uri ? std::get_if<std::string>(&uri->value().value) : nullptr;
    if (!uri || (written != nullptr && written->starts_with("data:"))) {
        place.sound_inside = number;
        if (const auto type = sounds_[number].find("mimeType"))
            place.sound_type = type->string("a type");
        return;
    }
    const std::string text = decode_percent(uri->string("a file beside this one"));
    const std::filesystem::path file = utf8_path(text);
    const bool is_beside =
        file.is_relative() && std::find(file.begin(), file.end(), "..") == file.end();
    if (is_beside && text.find(':') == std::string::npos) place.sound = text;
}

}  // namespace aula
