#include "engine/room_survey.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "engine/sampling.h"

namespace aula {

namespace {

constexpr int kSurveyPaths = 2048;
constexpr int kSurveyBounces = 32;

/// Pieces of a segment, which moving objects divide, in the mean of a path: who does not get out of
/// them ends.
constexpr int kMostPieces = 4;

}  // namespace

void flood(const RayScene& scene, std::span<const Vec3> inside, int paths, int bounces,
           std::uint64_t seed, const std::function<void(int, const Ray&, const Hit&)>& visit) {
    if (inside.empty()) return;
    const auto count = static_cast<std::size_t>(paths);
    std::vector<Ray> rays(count);
    std::vector<Vec3> begin(count);  // of the segment, before it passed through anything
    std::vector<Hit> passed(count);  // the first that it passed through
    std::vector<RandomStream> random(count);
    std::vector<int> reflections(count, 0);
    std::vector<Hit> hits(count);
    const ScrambledSobol sobol(seed);
    for (std::size_t i = 0; i < count; ++i) {
        random[i] = RandomStream(derive_seed(seed, i));
        rays[i] = {inside[i % inside.size()],
                   uniform_direction(sobol.point(static_cast<std::uint32_t>(i)))};
        begin[i] = rays[i].origin;
    }
    for (int piece = 0; piece < kMostPieces * bounces && !rays.empty(); ++piece) {
        hits.resize(rays.size());
        scene.intersect(rays, hits);
        std::size_t alive = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const Vec3 direction = rays[i].direction;
            if (hits[i].any() && scene.moves(scene.triangle(hits[i].triangle))) {
                const Vec3 through = scene.facing_normal(hits[i], direction);
                rays[alive] = {scene.point(hits[i], direction) - 2 * RayScene::kOffset_m * through,
                               direction};
                begin[alive] = begin[i];
                passed[alive] = passed[i].any() ? passed[i] : hits[i];
            } else {
                Hit hit = hits[i].any() ? hits[i] : passed[i];
                if (hit.any()) {
                    hit.distance_m = glm::distance(begin[i], scene.point(hit, direction));
                }
                visit(reflections[i], {begin[i], direction}, hit);
                if (!hit.any()) continue;
                if (++reflections[i] == bounces) continue;
                begin[alive] = scene.point(hit, direction);
                rays[alive] = {begin[alive], lambert_direction(scene.facing_normal(hit, direction),
                                                               random[i].uniform_2d())};
                passed[alive] = {};
            }
            random[alive] = random[i];
            reflections[alive] = reflections[i];
            ++alive;
        }
        rays.resize(alive);
        begin.resize(alive);
        passed.resize(alive);
        random.resize(alive);
        reflections.resize(alive);
    }
}

RoomSurvey survey_room(const RayScene& scene, std::span<const Vec3> inside, std::uint64_t seed) {
    double length_m = 0;
    std::size_t hits = 0;
    std::size_t escaped = 0;
    std::array<double, kBandCount> absorption{};
    flood(scene, inside, kSurveyPaths, kSurveyBounces, seed, [&](int, const Ray&, const Hit& hit) {
        if (!hit.any()) {
            ++escaped;
            return;
        }
        ++hits;
        length_m += double{hit.distance_m};
        const Material& material = scene.material(scene.triangle(hit.triangle));
        for (std::size_t b = 0; b < kBandCount; ++b) {
            absorption[b] += double{material.absorption[b]};
        }
    });
    RoomSurvey survey;
    if (hits == 0) return survey;
    survey.mean_free_path_m = length_m / static_cast<double>(hits);
    for (std::size_t b = 0; b < kBandCount; ++b) {
        survey.mean_absorption[b] = static_cast<float>(
            (absorption[b] + static_cast<double>(escaped)) / static_cast<double>(hits + escaped));
    }
    return survey;
}

Bands reverberation_time_s(const RoomSurvey& survey, const Medium& medium) {
    Bands time_s;
    if (!(survey.mean_free_path_m > 0)) return time_s;
    const double c = double{medium.speed_of_sound_m_s()};
    const Bands attenuation = medium.attenuation_per_m();
    for (std::size_t b = 0; b < kBandCount; ++b) {
        // Eyring with the mean free path l: energy falls as exp(-(m - ln(1 - a) / l) c t).
        const double per_m = double{attenuation[b]} -
                             std::log1p(-std::min(0.999, double{survey.mean_absorption[b]})) /
                                 survey.mean_free_path_m;
        time_s[b] = static_cast<float>(std::min(100.0, 6 * std::log(10.0) / (c * per_m + 1e-9)));
    }
    return time_s;
}

}  // namespace aula
