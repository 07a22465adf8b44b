#include "apps/window/colours.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <utility>

namespace aula {

namespace {

/// Substrings of material names with their colours; the first match counts.
constexpr std::array<std::pair<const char*, Colour>, 31> kNamed{{
    {"rubble", {0.70F, 0.64F, 0.55F}},    {"pew", {0.50F, 0.33F, 0.22F}},
    {"leather", {0.40F, 0.26F, 0.20F}},   {"plaster", {0.86F, 0.83F, 0.77F}},
    {"gypsum", {0.88F, 0.87F, 0.83F}},    {"curtain", {0.62F, 0.20F, 0.24F}},
    {"carpet", {0.36F, 0.42F, 0.55F}},    {"door", {0.55F, 0.38F, 0.22F}},
    {"parquet", {0.70F, 0.50F, 0.30F}},   {"wood", {0.68F, 0.50F, 0.32F}},
    {"brick", {0.66F, 0.36F, 0.28F}},     {"glass", {0.62F, 0.78F, 0.85F}},
    {"window", {0.62F, 0.78F, 0.85F}},    {"concrete", {0.62F, 0.62F, 0.60F}},
    {"tile", {0.80F, 0.87F, 0.86F}},      {"marble", {0.90F, 0.88F, 0.86F}},
    {"limestone", {0.85F, 0.79F, 0.66F}}, {"stone", {0.72F, 0.68F, 0.60F}},
    {"metal", {0.62F, 0.66F, 0.70F}},     {"steel", {0.62F, 0.66F, 0.70F}},
    {"grass", {0.45F, 0.60F, 0.32F}},     {"water", {0.35F, 0.55F, 0.70F}},
    {"audience", {0.50F, 0.36F, 0.52F}},  {"seat", {0.52F, 0.28F, 0.30F}},
    {"ceramic", {0.93F, 0.93F, 0.92F}},   {"mirror", {0.75F, 0.82F, 0.86F}},
    {"fabric", {0.48F, 0.44F, 0.56F}},    {"towel", {0.72F, 0.62F, 0.70F}},
    {"floor", {0.58F, 0.52F, 0.46F}},     {"ceiling", {0.90F, 0.89F, 0.86F}},
    {"wall", {0.84F, 0.81F, 0.76F}},
}};

Colour from_hue(float hue, float saturation, float value) {
    const auto channel = [&](float shift) {
        const float k = std::fmod(shift + hue * 6, 6.0F);
        return value - value * saturation * std::clamp(std::min(k, 4 - k), 0.0F, 1.0F);
    };
    return {channel(5), channel(3), channel(1)};
}

}  // namespace

Colour material_colour(const Material& material) {
    for (const auto& [part, colour] : kNamed)
        if (material.name.find(part) != std::string::npos) return colour;
    const std::size_t hash = std::hash<std::string>{}(material.name);
    // Hues from red to yellow-green at low saturation, as of most walls.
    return from_hue(static_cast<float>(hash % 100) / 360, 0.18F, 0.74F);
}

Colour order_colour(int order) {
    static constexpr std::array<Colour, 7> kOrders{{
        {1.00F, 1.00F, 1.00F},
        {1.00F, 0.82F, 0.25F},
        {1.00F, 0.52F, 0.20F},
        {0.93F, 0.28F, 0.38F},
        {0.72F, 0.30F, 0.75F},
        {0.40F, 0.45F, 0.95F},
        {0.25F, 0.70F, 0.85F},
    }};
    return kOrders[static_cast<std::size_t>(std::clamp(order, 0, 6))];
}

Colour band_colour(std::size_t band) {
    return from_hue(0.78F * static_cast<float>(band) / (kBandCount - 1), 0.6F, 0.95F);
}

}  // namespace aula
