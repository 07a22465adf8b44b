#include "apps/room/frames/frame_maker.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <string>
#include <unordered_map>
#include <utility>

#include "apps/room/frames/ray_budget.h"
#include "apps/room/frames/sound_at_listener.h"
#include "audio/render/render_memory.h"
#include "aula/exception.h"

namespace aula {

namespace {

// Of a response the part that is made on one thread, RenderFrameBuilder::prepare(), takes 0.4 of
// the time of the other: more threads save less than an eighth of both.
constexpr int kMostThreads = 8;

// At a walk of 1.5 m/s the phases of waves from opposite directions differ by less than half a
// period from step to step up to 3.4 kHz.
constexpr double kSteps_hz = 60;

/// The settings of the renderer of each listener. Throws InputError if the renderers take more
/// memory than allowed.
RendererConfig checked_config(RendererConfig config, const FrameSettings& settings,
                              const Hrtf* hrtf) {
    config.steps_hz = kSteps_hz;
    const std::uint64_t more = settings.listeners * settings.headphones_bytes;
    const std::uint64_t renderers = renderer_bytes(config, hrtf, settings.listeners);
    const std::uint64_t bytes = std::max(renderers, renderers + more);  // no overflow
    if (bytes > settings.max_memory_bytes)
        throw InputError("auralizer: its renderers take " + std::to_string(bytes) +
                         " bytes; expected at most " + std::to_string(settings.max_memory_bytes) +
                         ": fewer max_sources or listeners, shorter responses, or a larger "
                         "max_memory_bytes");
    return config;
}

SourceSound absent_sound() {
    SourceSound sound;
    sound.absent = true;
    return sound;
}

}  // namespace

FrameMaker::FrameMaker(const Scene& scene, const FrameSettings& settings,
                       std::shared_ptr<const Hrtf> hrtf)
    : simulation_(scene.simulation),
      propagation_(scene, scene.simulation, settings.listeners),
      config_(checked_config(renderer_config(scene, propagation_.response_length_s(), settings),
                             settings, hrtf.get())),
      carriers_(make_noise_carriers(settings.sample_rate_hz, scene.simulation.seed)),
      waves_(scene, settings.waves_ready),
      medium_(scene.medium),
      speed_of_sound_m_s_(scene.medium.speed_of_sound_m_s()),
      rays_(scene.simulation.ray_count()),
      listeners_(settings.listeners),
      slot_sources_(config_.sources),
      workers_(std::min({scene.simulation.threads.value_or(default_threads()), kMostThreads,
                         static_cast<int>(config_.sources)})) {
    for (int thread = 0; thread < workers_.threads(); ++thread)
        workspaces_.push_back(std::make_unique<Workspace>(config_));
    for (std::size_t l = 0; l < settings.listeners; ++l)
        builders_.push_back(std::make_unique<RenderFrameBuilder>(config_, hrtf));
    input_.listeners.resize(settings.listeners);
    for (const SourceState& source : room_state(scene, 0).sources)
        voices_.push_back(make_voice(source));
}

FrameMaker::Voice FrameMaker::make_voice(const SourceState& source) const {
    return {source,
            std::make_unique<ImpulseResponseBuilder>(carriers_, medium_,
                                                     propagation_.response_length_s(), source.name,
                                                     field_order(config_)),
            SourceTrajectory(config_.longest_delay_s),
            {},
            {},
            {}};
}

int FrameMaker::rays_wanted(const RoomState& room) const {
    if (room.frame_share && frame_s_ > 0)
        return rays_within_budget(rays_, statistics(), frame_s_,
                                  *room.frame_share * config_.frame_s, voices_.size());
    if (room.work_s && frame_s_ > 0)
        return rays_within_work(rays_, statistics(), *room.work_s, voices_.size());
    return room.rays.value_or(simulation_.ray_count());
}

void FrameMaker::take_sources(const std::vector<SourceState>& sources) {
    const auto find = [&](std::uint64_t id) {
        return std::find_if(sources.begin(), sources.end(),
                            [&](const SourceState& source) { return source.id == id; });
    };
    for (std::size_t v = voices_.size(); v-- > 0;) {
        Voice& voice = voices_[v];
        const auto source = find(voice.state.id);
        if (source != sources.end() && !source->removed_at) continue;
        if (source != sources.end()) {
            voice.last.resize(builders_.size());
            for (std::size_t l = 0; l < voice.last.size(); ++l) build_response(v, l, voice.last[l]);
            ringing_.push_back(std::move(voice));
        }
        propagation_.remove_source(v);
        voices_.erase(voices_.begin() + static_cast<std::ptrdiff_t>(v));
    }
    std::erase_if(ringing_,
                  [&](const Voice& voice) { return find(voice.state.id) == sources.end(); });
    for (const SourceState& source : sources) {
        const auto voice = std::find_if(voices_.begin(), voices_.end(),
                                        [&](const Voice& v) { return v.state.id == source.id; });
        if (voice != voices_.end()) {
            voice->state = source;
        } else if (!source.removed_at) {
            propagation_.add_source(source.pose, source.directivity);
            voices_.push_back(make_voice(source));
        }
    }
}

void FrameMaker::propagate(const RoomState& room) {
    if (const int wanted = rays_wanted(room); wanted != rays_) {
        propagation_.set_rays(wanted);
        rays_ = wanted;
    }
    take_sources(room.sources);
    listeners_ = room.listeners;
    input_.time_s = room.time_s;
    input_.objects = room.objects;
    for (std::size_t l = 0; l < room.listeners.size(); ++l)
        input_.listeners[l] = room.listeners[l].position;
    input_.sources.clear();
    input_.source_rotations.clear();
    for (Voice& voice : voices_) {
        voice.trajectory.add(room.time_s, voice.state.pose.position,
                             static_cast<double>(speed_of_sound_m_s_));
        input_.sources.push_back(voice.state.pose.position);
        input_.source_rotations.push_back(voice.state.pose.rotation());
    }
    waves_.begin_frame(room.time_s, input_.sources, room.objects);
    propagation_.step(input_);
}

void FrameMaker::warm_up(const RoomState& room, double longest_s) {
    const auto end = std::chrono::steady_clock::now() +
                     std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                         std::chrono::duration<double>(longest_s));
    for (int frame = 0; frame < simulation_.window_frames(); ++frame) {
        if (std::chrono::steady_clock::now() >= end) break;
        propagate(room);
    }
    // A builder's first response takes longer than later ones.
    for (std::size_t v = 0; v < voices_.size(); ++v)
        build_response(v, 0, workspaces_[0]->steps.back());
}

/// The energies of a voice at a listener who has covered a share of the way from the place of the
/// frame before. The energies of bins, and paths that were in both frames, change linearly.
EnergyResponse FrameMaker::between(std::size_t voice, std::size_t listener, float share) const {
    EnergyResponse rays = propagation_.response(voice, listener);
    const EnergyResponse& last = voices_[voice].before[listener];
    rays.listener = glm::mix(last.listener, rays.listener, share);
    if (rays.bins == last.bins) {
        for (std::size_t i = 0; i < rays.bins.count(); ++i) {
            rays.energy[i] = last.energy[i] * (1 - share) + rays.energy[i] * share;
            rays.directions[i] = last.directions[i] * (1 - share) + rays.directions[i] * share;
        }
    }
    std::unordered_map<std::uint64_t, const SoundPath*> paths_before;
    for (const SoundPath& path : last.paths) paths_before.emplace(path.key, &path);
    for (SoundPath& path : rays.paths) {
        const auto found = paths_before.find(path.key);
        if (found == paths_before.end()) continue;
        const SoundPath* const before = found->second;
        path.length_m = std::lerp(before->length_m, path.length_m, share);
        path.direction = glm::mix(before->direction, path.direction, share);
        for (std::size_t b = 0; b < kBandCount; ++b)
            path.energy[b] = std::lerp(before->energy[b], path.energy[b], share);
    }
    return rays;
}

/// Keeps what the steps of the next frame begin with.
void FrameMaker::keep_responses() {
    if (frame_steps(config_) == 1) return;
    for (std::size_t v = 0; v < voices_.size(); ++v) {
        voices_[v].before.resize(listeners_.size());
        for (std::size_t l = 0; l < listeners_.size(); ++l)
            voices_[v].before[l] = propagation_.response(v, l);
    }
}

/// The newest response of a voice that is not ringing out.
void FrameMaker::build_response(std::size_t voice, std::size_t listener,
                                ImpulseResponse& response) const {
    synthesise(workspaces_[0]->synthesis, voice, propagation_.response(voice, listener), response,
               nullptr, ImpulseResponseBuilder::kWhole);
}

/// Likewise in all steps of the frame: a step that is not whole has its beginning. [several
/// threads, for different voices]
void FrameMaker::build_steps(std::size_t voice, std::size_t listener, Workspace& workspace) {
    Voice& of = voices_[voice];
    of.scales.resize(listeners_.size());
    const std::size_t steps = workspace.steps.size();
    for (std::size_t step = 0; step < steps; ++step) {
        std::optional<EnergyResponse> moving;
        if (step + 1 < steps && !of.before.empty())
            moving =
                between(voice, listener, static_cast<float>(step + 1) / static_cast<float>(steps));
        synthesise(workspace.synthesis, voice,
                   moving ? *moving : propagation_.response(voice, listener), workspace.steps[step],
                   &of.scales[listener], builders_[listener]->step_samples(step));
    }
}

void FrameMaker::synthesise(WaveSynthesis& synthesis, std::size_t voice, const EnergyResponse& rays,
                            ImpulseResponse& response, TailScale* scale,
                            std::size_t samples) const {
    const Voice& of = voices_[voice];
    synthesis.build(
        *of.impulse_responses, rays, waves_.pair(of.state.pose.position, rays.listener, rays),
        [&](const SoundPath& path) {
            return of.trajectory.delay_s(path, double{speed_of_sound_m_s_});
        },
        response, scale, samples);
    if (gains_.late == 1) return;
    for (std::vector<float>& channel : response.channels)
        for (float& sample : channel) sample *= gains_.late;
}

/// A response of a voice, with the gains applied.
SourceSound FrameMaker::sound_of(const Voice& voice, const ImpulseResponse& response) const {
    return source_sound(response, static_cast<double>(speed_of_sound_m_s_), voice.state.gain_db,
                        gains_.direct, gains_.early, &voice.trajectory);
}

void FrameMaker::fill(const RoomState& room, std::span<const std::unique_ptr<RenderFrame>> frames) {
    const auto begin = std::chrono::steady_clock::now();
    propagate(room);
    gains_ = {room.direct_gain, room.early_gain, room.late_gain};
    const std::vector<std::uint64_t> before =
        std::exchange(slot_sources_, std::vector<std::uint64_t>(slot_sources_.size()));
    // A slot is absent for a frame between two sources, so that neither is heard through the
    // response of the other.
    std::vector<const Voice*> playing(slot_sources_.size());
    for (const std::vector<Voice>* const voices : {&ringing_, &voices_}) {
        for (const Voice& voice : *voices) {
            const std::size_t slot = voice.state.slot;
            if (before[slot] != 0 && before[slot] != voice.state.id) continue;
            slot_sources_[slot] = voice.state.id;
            playing[slot] = &voice;
        }
    }
    const auto present =
        static_cast<std::size_t>(std::count_if(playing.begin(), playing.end(), std::identity()));
    for (std::size_t l = 0; l < frames.size(); ++l) {
        if (room.exchange) builders_[l]->set_exchange(room.exchange->first, room.exchange->second);
        const auto prepare = [&](std::size_t slot, const auto& sound) {
            for (std::size_t step = 0; step < frame_steps(config_); ++step)
                builders_[l]->prepare(slot, sound(step), present, *frames[l], step);
        };
        std::vector<const Voice*> built;
        for (std::size_t slot = 0; slot < playing.size(); ++slot) {
            const Voice* const voice = playing[slot];
            if (voice == nullptr)
                prepare(slot, [](std::size_t) { return absent_sound(); });
            else if (!voice->last.empty())
                prepare(slot, [&](std::size_t) { return sound_of(*voice, voice->last[l]); });
            else
                built.push_back(voice);
        }
        for (std::size_t first = 0; first < built.size(); first += workspaces_.size()) {
            const auto voices =
                std::span(built).subspan(first, std::min(workspaces_.size(), built.size() - first));
            workers_.run(voices.size(), [&](std::size_t i) {
                build_steps(static_cast<std::size_t>(voices[i] - voices_.data()), l,
                            *workspaces_[i]);
            });
            for (std::size_t i = 0; i < voices.size(); ++i)
                prepare(voices[i]->state.slot, [&](std::size_t step) {
                    return sound_of(*voices[i], workspaces_[i]->steps[step]);
                });
        }
    }
    keep_responses();
    frame_s_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

double FrameMaker::longest_delay_s(std::uint64_t id) const {
    double longest_s = 0;
    const auto add = [&](const Voice& voice, const std::vector<SoundPath>& paths) {
        for (const SoundPath& path : paths)
            longest_s = std::max(longest_s, voice.trajectory.delay_s(
                                                path, static_cast<double>(speed_of_sound_m_s_)));
    };
    for (std::size_t v = 0; v < voices_.size(); ++v) {
        if (voices_[v].state.id != id) continue;
        for (std::size_t l = 0; l < builders_.size(); ++l)
            add(voices_[v], propagation_.response(v, l).paths);
    }
    for (const Voice& voice : ringing_) {
        if (voice.state.id != id) continue;
        for (const ImpulseResponse& response : voice.last) add(voice, response.paths);
    }
    return std::min(config_.longest_delay_s, longest_s);
}

std::optional<HeardSound> FrameMaker::sound(std::uint64_t id, std::size_t listener) const {
    for (std::size_t v = 0; v < voices_.size(); ++v) {
        if (voices_[v].state.id != id || !is_playing(voices_[v])) continue;
        HeardSound heard;
        build_response(v, listener, heard.response);
        heard.sound = sound_of(voices_[v], heard.response);
        return heard;
    }
    return {};
}

bool FrameMaker::visible(std::uint64_t id, std::size_t listener) const {
    const auto is_straight = [](const SoundPath& path) {
        return path.kind == SoundPath::Kind::direct;
    };
    for (std::size_t v = 0; v < voices_.size(); ++v) {
        if (voices_[v].state.id != id) continue;
        const std::vector<SoundPath>& paths = propagation_.response(v, listener).paths;
        return std::any_of(paths.begin(), paths.end(), is_straight);
    }
    return false;
}

bool FrameMaker::reaches(std::uint64_t id, std::size_t listener) const {
    const auto has_energy = [](const Bands& energy) { return energy.max() > 0; };
    for (std::size_t v = 0; v < voices_.size(); ++v) {
        if (voices_[v].state.id != id) continue;
        const EnergyResponse& rays = propagation_.response(v, listener);
        return std::any_of(rays.paths.begin(), rays.paths.end(),
                           [&](const SoundPath& path) { return has_energy(path.energy); }) ||
               std::any_of(rays.energy.begin(), rays.energy.end(), has_energy) ||
               waves_.pair(voices_[v].state.pose.position, rays.listener, rays).has_value();
    }
    return false;
}

FrameView FrameMaker::view(const ViewRequest& request) const {
    FrameView view;
    if (voices_.empty()) return view;
    view.source = std::min(request.source, voices_.size() - 1);
    view.listener = listeners_[0];
    view.sources = input_.sources;
    view.source_rotations = input_.source_rotations;
    view.simulation = simulation_;
    view.simulation.rays = rays_;
    view.response = propagation_.response(view.source);
    view.length_s = response_length_s();
    view.impulse_response.assign(request.columns, 0);
    if (is_playing(voices_[view.source])) {
        ImpulseResponse response;
        build_response(view.source, 0, response);
        const std::vector<float>& pressure = response.channels[0];
        for (std::size_t i = 0; i < pressure.size(); ++i) {
            float& column = view.impulse_response[i * request.columns / pressure.size()];
            column = std::max(column, std::abs(pressure[i]));
        }
    }
    if (request.lines > 0)
        view.lines =
            propagation_.path_lines(input_, view.source, request.lines, request.line_order);
    if (request.edges) view.edges = propagation_.edge_lines();
    if (request.patches)
        view.patches = propagation_.patch_energies(view.source, request.patches_begin_s,
                                                   request.patches_end_s);
    view.patch_size_m = propagation_.patch_size_m();
    return view;
}

}  // namespace aula
