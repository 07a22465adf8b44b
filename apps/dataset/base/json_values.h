#pragma once

#include <string>
#include <string_view>
#include <utility>

#include "aula/engine/bands.h"
#include "aula/engine/vec3.h"
#include "engine/input/json.h"

namespace aula {

// JSON values of numbers, texts, lists and objects.

inline JsonValue json_value(double number) { return {number}; }
inline JsonValue json_value(std::uint64_t number) { return {number}; }
inline JsonValue json_value(std::string text) { return {std::move(text)}; }

/// A list, or an object, from its elements.
inline JsonValue json_value(JsonValue::Array elements) { return {std::move(elements)}; }
inline JsonValue json_value(JsonValue::Object members) { return {std::move(members)}; }

/// A number in single precision as the decimal that it was written as, of at most 6 digits after
/// the point.
inline JsonValue json_value(float number) {
    return {static_cast<double>(std::llround(double{number} * 1e6)) / 1e6};
}

inline JsonValue json_value(const Vec3& v) {
    return json_value(JsonValue::Array{json_value(v.x), json_value(v.y), json_value(v.z)});
}

inline JsonValue json_value(const Bands& bands) {
    JsonValue::Array list;
    for (const float x : bands.value) list.push_back(json_value(x));
    return json_value(std::move(list));
}

/// The member of an object, or null.
inline const JsonValue* find_member(const JsonValue::Object& object, std::string_view key) {
    for (const JsonMember& member : object)
        if (member.key == key) return &member.value;
    return nullptr;
}

}  // namespace aula
