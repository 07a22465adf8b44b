#include "aula/engine/propagation.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <glm/geometric.hpp>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

#include "aula/exception.h"
#include "engine/base/sampling.h"
#include "engine/base/stopwatch.h"
#include "engine/base/worker_pool.h"
#include "engine/direct/direct_sound.h"
#include "engine/estimate/patch_propagation.h"
#include "engine/estimate/path_propagation.h"
#include "engine/estimate/response_length.h"
#include "engine/frame_rays.h"
#include "engine/rays/nudge_off_surface.h"
#include "engine/rays/room_survey.h"
#include "engine/rays/wall_crossing.h"
#include "engine/scene/scene_positions.h"

namespace aula {

namespace {

enum class SeedPurpose : std::uint64_t { frame = 1, survey = 3, specular = 5, connection = 7 };

Material opaque(Material material) {
    material.sound_reduction_db.reset();
    return material;
}

Scene with_opaque_walls(Scene scene) {
    for (Material& material : scene.materials) material = opaque(std::move(material));
    return scene;
}

/// A hash of objects where they are without a movement.
std::uint64_t hash_of(const std::vector<Object>& objects) {
    std::uint64_t hash = 0;
    for (const Object& object : objects)
        for (const Vec3& v : object.vertices)
            for (int axis = 0; axis < 3; ++axis)
                hash = derive_seed(
                    hash, std::bit_cast<std::uint32_t>(v[axis] + object.translation[axis]));
    return hash;
}

/// A source and its pairs.
struct SourcePairs {
    std::shared_ptr<const EmissionSampler> sampler;  ///< null: omnidirectional
    std::vector<Pair> pairs;                         ///< [listener]
    std::vector<Pair> at_rest{};                     ///< [receiver] of the newest responses_at()
};

}  // namespace

struct Propagation::State {
    Scene scene;
    Simulation simulation;
    std::size_t listener_count;
    float speed_of_sound_m_s;
    Bands attenuation_per_m;
    RayScene rays;
    WorkerPool workers;
    std::vector<Vec3> inside;
    TimeBins bins;
    std::uint64_t room;  // hash of the geometry
    SpecularPaths specular;
    std::optional<DirectSound> direct_sound;  // where the scene has edges that diffract it
    std::unique_ptr<ResponseEstimator> estimator;
    PatchPropagation* patches = nullptr;  // the estimator; null for those without patches
    std::vector<SourcePairs> sources;
    std::optional<FrameInput> at_rest;  // of the newest responses_at()
    std::uint64_t seed;
    std::uint64_t frame = 0;
    double travel_m = 0;  // accumulated movement of the scene since the start
    std::size_t next_source_id;
    FrameStatistics statistics;

    State(const Scene& given, const Simulation& settings, std::size_t listeners,
          std::span<const Vec3> receivers)
        : scene(settings.transmission ? given : with_opaque_walls(given)),
          simulation((settings.check(), settings)),
          listener_count(listeners),
          speed_of_sound_m_s(scene.medium.speed_of_sound_m_s()),
          attenuation_per_m(scene.medium.attenuation_per_m()),
          rays(scene),
          workers(settings.threads.value_or(default_threads())),
          inside(nudge_off_surfaces(rays, scene_positions(scene))),
          bins(response_length_s(receivers)),
          room(hash_of(scene.objects)),
          specular(
              rays, image_source_order(), settings.listener_radius_m,
              derive_seed(settings.seed, SeedPurpose::specular),
              settings.order > 0 ? 0 : bins.length_s() * double{scene.medium.speed_of_sound_m_s()}),
          seed(settings.seed),
          next_source_id(scene.sources.size() + listeners) {
        if (simulation.direct && simulation.diffraction_order > 0) {
            direct_sound.emplace(rays, speed_of_sound_m_s, simulation.diffraction_order);
            const SceneEdges& edges = direct_sound->edges();
            if (edges.count() == 0 && !edges.has_small()) direct_sound.reset();
        }
        for (const Source& source : scene.sources)
            sources.push_back(make_source(source.directivity));
        TraceSettings trace;
        trace.rays = simulation.ray_count();
        trace.order = simulation.order;
        trace.specular = simulation.specular;
        trace.max_length_m = static_cast<float>(bins.length_s()) * speed_of_sound_m_s;
        trace.speed_of_sound_m_s = speed_of_sound_m_s;
        trace.attenuation_per_m = attenuation_per_m;
        if (simulation.estimator == Estimator::patch) {
            auto made =
                std::make_unique<PatchPropagation>(rays, specular, simulation, trace, bins, inside,
                                                   sources.size(), listener_count, workers);
            patches = made.get();
            estimator = std::move(made);
        } else {
            estimator = std::make_unique<PathPropagation>(rays, specular, simulation, trace,
                                                          sources.size(), listener_count, workers);
        }
        if (direct_sound) search_at_start();
    }

    /// The first search for paths over edges, which takes longer than those of later frames.
    void search_at_start() {
        const Vec3 listener = scene.listener.pose_at(0).position;
        direct_sound->begin_frame(false);
        for (std::size_t s = 0; s < sources.size(); ++s)
            direct_sound->search(scene.sources[s].position_at(0), listener,
                                 sources[s].pairs[0].memory);
    }

    /// Discards what search_at_start() found for pairs that are elsewhere in the first frame.
    static void begin_elsewhere(std::span<const FramePair> pairs, bool moved) {
        for (const FramePair& p : pairs) {
            if (moved || !p.pair.memory.chains.is_between(p.source, p.listener)) p.pair.memory = {};
        }
    }

    /// Highest order of the image sources; the limit of the reflection order applies to them as
    /// well.
    int image_source_order() const {
        if (!simulation.specular) return 0;
        return simulation.order > 0 ? std::min(simulation.order, simulation.specular_order)
                                    : simulation.specular_order;
    }

    double response_length_s(std::span<const Vec3> receivers) {
        if (simulation.ir_length_s) return double{*simulation.ir_length_s};
        std::vector<Vec3> listeners = listener_positions(scene);
        listeners.insert(listeners.end(), receivers.begin(), receivers.end());
        return sounding_length_s(
            rays, scene.medium, simulation.order, nudge_off_surfaces(rays, source_positions(scene)),
            nudge_off_surfaces(rays, std::move(listeners)), double{Simulation::kMaxIrLength_s},
            derive_seed(simulation.seed, SeedPurpose::survey), workers);
    }

    EnergyResponse silent() const { return EnergyResponse::silent(bins, speed_of_sound_m_s); }

    /// Sets what the responses of all sources at some listeners say of their place.
    void set_places(std::span<const Vec3> listeners, std::span<const FramePair> pairs) const {
        for (std::size_t i = 0; i < pairs.size(); ++i) {
            pairs[i].pair.response.listener = listeners[i % listeners.size()];
            pairs[i].pair.response.room = room;
        }
    }

    std::vector<Pair> silent_pairs() const {
        return std::vector<Pair>(listener_count, {silent(), {}, {}});
    }

    SourcePairs make_source(const Directivity& directivity) const {
        return {directivity.is_omnidirectional() ? nullptr
                                                 : std::make_shared<EmissionSampler>(directivity),
                silent_pairs()};
    }

    void add_source(const Pose& pose, const Directivity& directivity) {
        sources.push_back(make_source(directivity));
        at_rest.reset();  // no search has been made for its pairs
        estimator->add_source(next_source_id++, pose.position,
                              {sources.back().sampler, pose.rotation()});
    }

    void remove_source(std::size_t source) {
        sources.erase(sources.begin() + static_cast<std::ptrdiff_t>(source));
        estimator->remove_source(source);
    }

    /// Invalidates all frames before a change of materials.
    void materials_changed() {
        // More than the movement at which cached segments expire.
        constexpr double kFar_m = 1000;
        travel_m += kFar_m;
        specular.materials_changed();
        if (direct_sound) direct_sound->materials_changed();
        if (patches) patches->materials_changed();
    }

    /// Clears all caches.
    void restart() {
        frame = 0;
        specular.restart(derive_seed(seed, SeedPurpose::specular));
        for (SourcePairs& source : sources) source.pairs = silent_pairs();
        estimator->restart();
    }

    /// The frame's positions, with those on surfaces moved off them: on a surface half of the rays
    /// would be lost.
    FrameInput nudged(const FrameInput& given) const {
        FrameInput input = given;
        input.sources = nudge_off_surfaces(rays, std::move(input.sources));
        input.listeners = nudge_off_surfaces(rays, std::move(input.listeners));
        return input;
    }

    PropagationFrame frame_of(const FrameInput& input, std::uint64_t number) const {
        PropagationFrame made{input, number, derive_seed(seed, SeedPurpose::frame, number),
                              travel_m};
        for (std::size_t s = 0; s < sources.size(); ++s) {
            const bool turned = sources[s].sampler && !input.source_rotations.empty();
            made.directivities.emplace_back(sources[s].sampler,
                                            turned ? input.source_rotations[s] : glm::mat3(1));
        }
        return made;
    }

    /// `pairs` or `at_rest` of all sources in a frame, [source * listeners + listener].
    std::vector<FramePair> pairs_of(const PropagationFrame& frame,
                                    std::vector<Pair> SourcePairs::*of_source) {
        std::vector<FramePair> pairs;
        for (std::size_t s = 0; s < sources.size(); ++s)
            for (std::size_t l = 0; l < frame.input.listeners.size(); ++l)
                pairs.push_back({frame.input.sources[s], frame.input.listeners[l],
                                 frame.directivities[s], (sources[s].*of_source)[l]});
        return pairs;
    }

    /// The direct sound over edges and through walls, as the paths of all responses. A straight
    /// path without edges near it is left to find_specular().
    void find_direct_sound(std::span<const FramePair> pairs) {
        for (const FramePair& p : pairs) p.pair.response.paths.clear();
        if (!simulation.direct || !(direct_sound || rays.transmits())) return;
        for (std::size_t turn = 0; direct_sound && turn < pairs.size(); ++turn) {
            const FramePair& p =
                pairs[(direct_sound->first_pair(pairs.size()) + turn) % pairs.size()];
            direct_sound->search(p.source, p.listener, p.pair.memory);
        }
        workers.run(pairs.size(), [&](std::size_t i) {
            const auto& [source, listener, directivity, pair] = pairs[i];
            std::vector<SoundPath>& paths = pair.response.paths;
            if (direct_sound) {
                paths = direct_sound->find(source, listener, directivity, attenuation_per_m,
                                           pair.memory);
            } else if (auto path = path_through_walls(rays, source, listener, attenuation_per_m)) {
                path->energy *= directivity.factor(path->departure);
                paths.push_back(*std::move(path));
            }
        });
        if (direct_sound) statistics.edges = direct_sound->edges().count();
        for (const FramePair& p : pairs) {
            for (const SoundPath& path : p.pair.response.paths) {
                if (path.kind == SoundPath::Kind::bent) ++statistics.bent_paths;
                if (path.kind == SoundPath::Kind::through_walls) ++statistics.wall_paths;
            }
        }
    }

    /// Adds the diffraction of the first-order image sources at the edges of their faces to the
    /// paths of all responses. Where rays count image sources of order 1, these are left as they
    /// are.
    void complete_reflections(std::span<const FramePair> pairs) {
        if (!direct_sound || specular.listed_order() == 0) return;
        const FirstOrderImages first_order{specular.planes(), specular.first_order_ids(),
                                           specular.order()};
        workers.run(pairs.size(), [&](std::size_t i) {
            const auto& [source, listener, directivity, pair] = pairs[i];
            direct_sound->complete_reflections(pair.response.paths, source, listener, first_order,
                                               directivity, attenuation_per_m, pair.memory);
        });
    }

    /// Adds the image sources to the paths of all responses, and the direct sound if it is
    /// straight.
    void find_specular(std::span<const FramePair> pairs) {
        const auto find = [&](std::size_t i, WorkerPool* shared) {
            const auto& [source, listener, directivity, pair] = pairs[i];
            std::vector<SoundPath>& paths = pair.response.paths;
            const bool all_through_walls = std::all_of(
                paths.begin(), paths.end(),
                [](const SoundPath& path) { return path.kind == SoundPath::Kind::through_walls; });
            pair.images = specular.find(source, listener, simulation.direct && all_through_walls,
                                        attenuation_per_m, shared, sources.size());
            std::vector<SoundPath>& found = pair.images.paths;
            if (!directivity.is_omnidirectional()) {
                for (SoundPath& path : found) path.energy *= directivity.factor(path.departure);
            }
            const auto middle = paths.insert(paths.end(), found.begin(), found.end());
            std::inplace_merge(
                paths.begin(), middle, paths.end(),
                [](const SoundPath& a, const SoundPath& b) { return a.length_m < b.length_m; });
        };
        if (pairs.size() < static_cast<std::size_t>(workers.threads())) {
            for (std::size_t i = 0; i < pairs.size(); ++i) find(i, &workers);
        } else {
            workers.run(pairs.size(), [&](std::size_t i) { find(i, nullptr); });
        }
        for (const FramePair& p : pairs) statistics.image_reflections += p.pair.images.reflections;
    }

    /// Replaces the paths of all responses: direct sound and image sources, with their diffraction.
    void find_paths(const PropagationFrame& frame, std::span<const FramePair> pairs) {
        Stopwatch watch;
        find_direct_sound(pairs);
        statistics.diffraction_s += watch.lap_s();
        for (const Vec3& listener : frame.input.listeners)
            specular.discover(listener, frame.number, &workers);
        find_specular(pairs);
        statistics.specular_s += watch.lap_s();
        complete_reflections(pairs);
        statistics.diffraction_s += watch.lap_s();
    }

    /// The pairs of all sources with receivers, which are the listeners of `frame`. The searches
    /// for paths over edges go on until as many frames as test all edges change nothing. Their
    /// results remain while no position changes.
    std::vector<FramePair> resting_pairs(const PropagationFrame& frame) {
        constexpr int kMaxFrames = 64;
        const FrameInput& input = frame.input;
        const bool continues =
            at_rest && at_rest->sources == input.sources && at_rest->listeners == input.listeners;
        for (SourcePairs& source : sources) {
            source.at_rest.resize(input.listeners.size());
            for (Pair& pair : source.at_rest)
                pair = {silent(), {}, continues ? std::move(pair.memory) : PairMemory{}};
        }
        at_rest = input;
        std::vector<FramePair> pairs = pairs_of(frame, &SourcePairs::at_rest);
        if (!direct_sound) return pairs;
        std::vector<std::size_t> open(continues ? 0 : pairs.size());
        std::iota(open.begin(), open.end(), std::size_t{0});
        for (int number = 0; number < kMaxFrames && !open.empty(); ++number) {
            for (const std::size_t i : open) {
                // The work of a frame for each pair.
                direct_sound->begin_frame(false);
                direct_sound->search(pairs[i].source, pairs[i].listener, pairs[i].pair.memory);
            }
            workers.run(open.size(), [&](std::size_t i) {
                const auto& [source, listener, directivity, pair] = pairs[open[i]];
                direct_sound->find(source, listener, directivity, attenuation_per_m, pair.memory);
            });
            std::erase_if(open, [&](std::size_t i) {
                return pairs[i].pair.memory.equal_frames >= NearEdges::kTurns;
            });
        }
        direct_sound->begin_frame(false);
        return pairs;
    }
};

Propagation::Propagation(const Scene& scene, const Simulation& simulation,
                         std::size_t listener_count, std::span<const Vec3> receivers)
    : state_(std::make_unique<State>(scene, simulation, listener_count, receivers)) {
    assert(listener_count >= 1);
}

Propagation::~Propagation() = default;

void Propagation::add_source(const Pose& pose, const Directivity& directivity) {
    state_->add_source(pose, directivity);
}

void Propagation::remove_source(std::size_t source) { state_->remove_source(source); }

std::size_t Propagation::source_count() const { return state_->sources.size(); }

void Propagation::set_object_material(std::size_t object, const Material& material) {
    const bool transmits = state_->simulation.transmission;
    state_->rays.set_material(object, transmits ? material : opaque(material));
    state_->materials_changed();
}

void Propagation::change_material(std::size_t material, const Material& coefficients) {
    const bool transmits = state_->simulation.transmission;
    state_->rays.change_material(material, transmits ? coefficients : opaque(coefficients));
    state_->materials_changed();
}

void Propagation::step(const FrameInput& given) {
    State& s = *state_;
    assert(given.sources.size() == s.sources.size());
    assert(given.listeners.size() == s.listener_count);
    assert(given.source_rotations.empty() || given.source_rotations.size() == s.sources.size());
    s.statistics = {};

    // Move the objects.
    const float moved_m =
        given.objects.empty() ? s.rays.move(given.time_s) : s.rays.move(given.objects);
    if (moved_m > 0) {
        s.travel_m += double{moved_m};
        s.specular.scene_moved();
        s.at_rest.reset();
        if (s.patches) s.patches->scene_moved();
    }
    const FrameInput input = s.nudged(given);
    const PropagationFrame frame = s.frame_of(input, s.frame);
    const std::vector<FramePair> pairs = s.pairs_of(frame, &SourcePairs::pairs);

    if (s.direct_sound) s.direct_sound->begin_frame(moved_m > 0);
    if (s.direct_sound && s.frame == 0) State::begin_elsewhere(pairs, moved_m > 0);
    // The paths that image sources count are selected before the rays' paths are evaluated.
    s.find_paths(frame, pairs);
    s.estimator->step(frame, pairs, s.statistics);
    s.set_places(given.listeners, pairs);
    ++s.frame;
}

std::vector<EnergyResponse> Propagation::responses_at(const FrameInput& given,
                                                      std::span<const Vec3> receivers) {
    State& s = *state_;
    assert(s.frame > 0);
    if (!s.patches) throw InputError("responses_at: expected the estimator \"patch\"");
    FrameStatistics of_step = s.statistics;
    FrameInput input = given;
    input.listeners.assign(receivers.begin(), receivers.end());
    input = s.nudged(input);
    const PropagationFrame frame = s.frame_of(input, s.frame - 1);
    const std::vector<FramePair> pairs = s.resting_pairs(frame);
    s.find_paths(frame, pairs);
    of_step.image_reflections = s.statistics.image_reflections;
    s.statistics = of_step;
    s.patches->gather_at(frame, pairs, s.statistics);
    s.set_places(receivers, pairs);
    std::vector<EnergyResponse> responses;
    for (const FramePair& p : pairs) {
        responses.push_back(std::move(p.pair.response));
        p.pair.images = {};  // of many receivers they need much memory
    }
    return responses;
}

const EnergyResponse& Propagation::response(std::size_t source, std::size_t listener) const {
    return state_->sources[source].pairs[listener].response;
}

void Propagation::restart(std::uint64_t seed) {
    state_->seed = seed;
    state_->restart();
}

const FrameStatistics& Propagation::statistics() const { return state_->statistics; }

std::vector<PathLine> Propagation::path_lines(const FrameInput& given, std::size_t source,
                                              int count, int order) const {
    const State& s = *state_;
    if (s.frame == 0) return {};
    const FrameInput input = s.nudged(given);
    const int max = s.simulation.order > 0 ? std::min(order, s.simulation.order) : order;
    return s.estimator->path_lines(s.frame_of(input, s.frame - 1), source, count, max);
}

std::vector<PatchEnergy> Propagation::patch_energies(std::size_t source, double begin_s,
                                                     double end_s) const {
    if (!state_->patches) return {};
    return state_->patches->patch_energies(source, begin_s, end_s);
}

std::vector<EdgeLine> Propagation::edge_lines() const {
    std::vector<EdgeLine> lines;
    if (!state_->direct_sound) return lines;
    for (const DiffractionEdge& edge : state_->direct_sound->edges().all())
        lines.push_back({.from = Vec3(edge.start),
                         .to = Vec3(edge.point(edge.length_m)),
                         .bend_rad = edge.bend_rad(),
                         .triangle = edge.triangles[0],
                         .facing = Vec3(edge.direction(std::numbers::pi / 2))});
    return lines;
}

float Propagation::patch_size_m() const {
    return state_->patches ? state_->patches->patch_size_m() : 0;
}

std::vector<char> Propagation::sources_connected(const FrameInput& given) const {
    const State& s = *state_;
    const FrameInput input = s.nudged(given);
    return connected(s.rays, std::span(input.listeners).first(1), input.sources,
                     derive_seed(s.simulation.seed, SeedPurpose::connection));
}

void Propagation::set_rays(int rays) { state_->estimator->set_rays(rays); }

void Propagation::emit_from_listeners() {
    if (state_->patches) state_->patches->emit_from_listeners();
}

double Propagation::response_length_s() const {
    const auto& given = state_->simulation.ir_length_s;
    // The last bin may end later.
    return given ? double{*given}
                 : std::min(state_->bins.length_s(), double{Simulation::kMaxIrLength_s});
}

std::vector<Ray> FrameRays::of_next(const Propagation& propagation, const FrameInput& given) {
    const Propagation::State& s = *propagation.state_;
    const FrameInput input = s.nudged(given);
    return s.estimator->rays(s.frame_of(input, s.frame));
}

}  // namespace aula
