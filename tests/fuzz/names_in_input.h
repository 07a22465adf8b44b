#pragma once

#include <algorithm>
#include <string>

#include "engine/input/json.h"

namespace aula::test {

/// Whether a text in the input could name a file outside the folder, or a device.
inline bool names_other_folder(const JsonValue& json) {
    if (const auto* text = std::get_if<std::string>(&json.value))
        return text->find('/') != std::string::npos || text->starts_with("..");
    if (const auto* list = std::get_if<JsonValue::Array>(&json.value))
        return std::any_of(list->begin(), list->end(), names_other_folder);
    if (const auto* object = std::get_if<JsonValue::Object>(&json.value))
        return std::any_of(object->begin(), object->end(), [](const JsonMember& member) {
            return names_other_folder(member.value);
        });
    return false;
}

}  // namespace aula::test
