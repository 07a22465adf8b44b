#include "apps/window/gl/colours.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <optional>

#include "engine/input/material_guess.h"

namespace aula {

namespace {

struct NamedLook {
    const char* part;
    MaterialLook look;
};

using enum SurfacePattern;

/// Substrings of material names with their looks; the first match counts.
constexpr std::array kNamed{
    NamedLook{"rubble", {{0.70F, 0.64F, 0.55F}, blocks}},
    NamedLook{"plaster", {{0.86F, 0.83F, 0.77F}, plain}},
    NamedLook{"gypsum", {{0.88F, 0.87F, 0.83F}, panels}},
    NamedLook{"drywall", {{0.88F, 0.87F, 0.83F}, panels}},
    NamedLook{"acoustic", {{0.80F, 0.82F, 0.80F}, panels}},
    NamedLook{"perforated", {{0.78F, 0.76F, 0.70F}, panels}},
    NamedLook{"curtain", {{0.62F, 0.20F, 0.24F}, cloth}},
    NamedLook{"carpet", {{0.36F, 0.42F, 0.55F}, grains}},
    NamedLook{"door", {{0.55F, 0.38F, 0.22F}, plain}},
    NamedLook{"parquet", {{0.70F, 0.50F, 0.30F}, boards}},
    NamedLook{"pew", {{0.50F, 0.33F, 0.22F}, boards}},
    NamedLook{"leather", {{0.40F, 0.26F, 0.20F}, plain}},
    NamedLook{"wood_wool", {{0.72F, 0.66F, 0.50F}, grains}},
    NamedLook{"plywood", {{0.74F, 0.60F, 0.42F}, plain}},
    NamedLook{"wood", {{0.68F, 0.50F, 0.32F}, boards}},
    NamedLook{"boards", {{0.60F, 0.46F, 0.32F}, boards}},
    NamedLook{"brick", {{0.66F, 0.36F, 0.28F}, bricks}},
    NamedLook{"glaz", {{0.62F, 0.78F, 0.85F}, panes}},
    NamedLook{"glass", {{0.62F, 0.78F, 0.85F}, panes}},
    NamedLook{"window", {{0.62F, 0.78F, 0.85F}, panes}},
    NamedLook{"mirror", {{0.75F, 0.82F, 0.86F}, panes}},
    NamedLook{"concrete_block", {{0.62F, 0.62F, 0.60F}, blocks}},
    NamedLook{"concrete", {{0.62F, 0.62F, 0.60F}, plain}},
    NamedLook{"asphalt", {{0.34F, 0.34F, 0.36F}, grains}},
    NamedLook{"tile", {{0.80F, 0.87F, 0.86F}, tiles}},
    NamedLook{"enamel", {{0.93F, 0.93F, 0.92F}, plain}},
    NamedLook{"ceramic", {{0.93F, 0.93F, 0.92F}, plain}},
    NamedLook{"marble", {{0.90F, 0.88F, 0.86F}, blocks}},
    NamedLook{"limestone", {{0.85F, 0.79F, 0.66F}, blocks}},
    NamedLook{"stone", {{0.72F, 0.68F, 0.60F}, blocks}},
    NamedLook{"terrazzo", {{0.76F, 0.73F, 0.70F}, grains}},
    NamedLook{"linoleum", {{0.46F, 0.56F, 0.50F}, plain}},
    NamedLook{"rubber", {{0.30F, 0.32F, 0.34F}, plain}},
    NamedLook{"cork", {{0.66F, 0.52F, 0.36F}, grains}},
    NamedLook{"metal", {{0.62F, 0.66F, 0.70F}, ribs}},
    NamedLook{"steel", {{0.62F, 0.66F, 0.70F}, ribs}},
    NamedLook{"pipes", {{0.70F, 0.68F, 0.60F}, ribs}},
    NamedLook{"grille", {{0.50F, 0.52F, 0.54F}, ribs}},
    NamedLook{"blinds", {{0.78F, 0.77F, 0.72F}, ribs}},
    NamedLook{"grass", {{0.45F, 0.60F, 0.32F}, grains}},
    NamedLook{"foliage", {{0.36F, 0.52F, 0.28F}, grains}},
    NamedLook{"soil", {{0.44F, 0.34F, 0.26F}, grains}},
    NamedLook{"sand", {{0.82F, 0.74F, 0.56F}, grains}},
    NamedLook{"gravel", {{0.62F, 0.60F, 0.57F}, grains}},
    NamedLook{"snow", {{0.92F, 0.94F, 0.97F}, grains}},
    NamedLook{"water", {{0.35F, 0.55F, 0.70F}, plain}},
    NamedLook{"foam", {{0.34F, 0.34F, 0.40F}, grains}},
    NamedLook{"wool", {{0.74F, 0.68F, 0.46F}, grains}},
    NamedLook{"felt", {{0.46F, 0.46F, 0.50F}, grains}},
    NamedLook{"audience", {{0.50F, 0.36F, 0.52F}, grains}},
    NamedLook{"congregation", {{0.50F, 0.36F, 0.52F}, grains}},
    NamedLook{"orchestra", {{0.42F, 0.34F, 0.40F}, grains}},
    NamedLook{"seat", {{0.52F, 0.28F, 0.30F}, grains}},
    NamedLook{"bookshelf", {{0.52F, 0.36F, 0.26F}, ribs}},
    NamedLook{"partition", {{0.84F, 0.81F, 0.76F}, panels}},
    NamedLook{"fabric", {{0.48F, 0.44F, 0.56F}, cloth}},
    NamedLook{"towel", {{0.72F, 0.62F, 0.70F}, grains}},
    NamedLook{"stucco", {{0.87F, 0.83F, 0.74F}, plain}},
    NamedLook{"drap", {{0.58F, 0.24F, 0.28F}, cloth}},
    NamedLook{"panell", {{0.60F, 0.44F, 0.28F}, boards}},
    NamedLook{"paving", {{0.70F, 0.67F, 0.61F}, blocks}},
    NamedLook{"floor", {{0.62F, 0.46F, 0.30F}, boards}},
    NamedLook{"ceiling", {{0.90F, 0.89F, 0.86F}, plain}},
    NamedLook{"wall", {{0.84F, 0.81F, 0.76F}, plain}},
};

std::optional<MaterialLook> named_look(const std::string& name) {
    for (const NamedLook& named : kNamed)
        if (name.find(named.part) != std::string::npos) return named.look;
    return std::nullopt;
}

Colour from_hue(float hue, float saturation, float value) {
    const auto channel = [&](float shift) {
        const float k = std::fmod(shift + hue * 6, 6.0F);
        return value - value * saturation * std::clamp(std::min(k, 4 - k), 0.0F, 1.0F);
    };
    return {channel(5), channel(3), channel(1)};
}

}  // namespace

MaterialLook material_look(const std::string& name) {
    if (const auto look = named_look(name)) return *look;
    const MaterialGuess guess = guess_material(name);
    if (!guess.word.empty())
        if (const auto look = named_look(guess.material)) return *look;
    const std::size_t hash = std::hash<std::string>{}(name);
    return {from_hue(static_cast<float>(hash % 360) / 360, 0.22F, 0.74F), plain};
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
