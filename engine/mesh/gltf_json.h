#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "engine/input/json_reader.h"

namespace aula {

/// The items of a list of a glTF object; none if it is absent.
inline std::vector<JsonReader> gltf_list(const JsonReader& json, const char* key) {
    const auto found = json.find(key);
    return found ? found->items("a list") : std::vector<JsonReader>{};
}

/// An index into a list of `count` elements named `of`. Throws InputError if it is not below
/// `count`.
inline std::size_t gltf_index(const JsonReader& json, std::size_t count, const char* of) {
    const std::uint64_t index = json.unsigned_integer();
    if (index >= count) {
        json.fail(std::to_string(index) + " of " + std::to_string(count) + " " + of +
                  "; expected one that exists");
    }
    return index;
}

/// The extension that has sources and their sounds.
inline constexpr const char* kGltfAudio = "KHR_audio_emitter";

/// The object of an extension in another one, if it is there.
inline std::optional<JsonReader> gltf_extension(const JsonReader& json, const char* name) {
    const auto extensions = json.find("extensions");
    return extensions ? extensions->find(name) : std::nullopt;
}

/// What replaces an extension that compresses data.
inline constexpr const char* kUncompressed = "data without compression";

/// True if the file cannot be read without the extension `name`.
inline bool requires_gltf_extension(const JsonReader& root, const char* name) {
    const std::vector<JsonReader> required = gltf_list(root, "extensionsRequired");
    return std::any_of(required.begin(), required.end(),
                       [&](const JsonReader& item) { return item.is_text(name); });
}

/// Throws InputError if an object uses the extension `name`. `expected` replaces it.
inline void refuse_gltf_extension(const JsonReader& json, const char* name, const char* expected) {
    const auto extensions = json.find("extensions");
    if (extensions && extensions->find(name)) {
        extensions->fail(std::string(name) + " is not read; expected " + expected);
    }
}

}  // namespace aula
