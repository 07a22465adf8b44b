#include "apps/window/view/direct_lines.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace aula {

namespace {

constexpr float kFaintest = 0.1F;
constexpr float kRange_db = 40;
constexpr float kOfOthers = 2.0F / 3;

}  // namespace

std::vector<DirectLine> direct_lines(const EnergyResponse& response, const Vec3& source,
                                     const Vec3& listener) {
    float loudest = 0;
    for (const SoundPath& path : response.paths)
        if (path.order == 0) loudest = std::max(loudest, path.energy.sum());
    std::vector<DirectLine> lines;
    for (const SoundPath& path : response.paths) {
        if (path.order > 0 || !(path.energy.sum() > 0)) continue;
        DirectLine line{.points = {source}};
        line.points.insert(line.points.end(), path.apexes.begin(), path.apexes.end());
        line.points.push_back(listener);
        line.is_primary = path.is_main;
        line.through_walls = path.kind == SoundPath::Kind::through_walls;
        const float level_db = 10 * std::log10(path.energy.sum() / loudest);
        line.opacity = std::max(kFaintest, 1 + (1 - kFaintest) * level_db / kRange_db);
        if (!line.is_primary) line.opacity *= kOfOthers;
        lines.push_back(std::move(line));
    }
    return lines;
}

std::string direct_sound_text(const EnergyResponse& response) {
    std::string text = "not in sight";
    for (const SoundPath& path : response.paths) {
        if (path.order > 0) continue;
        if (path.kind == SoundPath::Kind::through_walls) text = "through walls";
        if (!path.is_main) continue;
        if (path.kind == SoundPath::Kind::direct) return "in sight";
        return path.edges == 1 ? "around an edge"
                               : "around " + std::to_string(path.edges) + " edges";
    }
    return text;
}

std::vector<std::array<Vec3, 2>> dashes(const Vec3& from, const Vec3& to, float dash_m) {
    const float pairs = std::max(0.0F, std::round(0.5F * (glm::distance(from, to) / dash_m - 1)));
    const float count = 2 * pairs + 1;  // of dashes and gaps
    std::vector<std::array<Vec3, 2>> all;
    for (float i = 0; i < count; i += 2)
        all.push_back({glm::mix(from, to, i / count), glm::mix(from, to, (i + 1) / count)});
    return all;
}

}  // namespace aula
