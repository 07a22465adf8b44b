#include "apps/session/frames/frame_maker.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "apps/session/frames/ray_budget.h"
#include "apps/session/frames/sound_at_listener.h"

namespace aula {

namespace {

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
      config_(renderer_config(scene, propagation_.response_length_s(), settings)),
      carriers_(make_noise_carriers(settings.sample_rate_hz, scene.simulation.seed)),
      speed_of_sound_m_s_(scene.medium.speed_of_sound_m_s()),
      rays_(scene.simulation.rays),
      listeners_(settings.listeners),
      sounds_(settings.listeners, std::vector<SourceSound>(config_.sources, absent_sound())),
      slot_sources_(config_.sources) {
    for (std::size_t l = 0; l < settings.listeners; ++l)
        builders_.push_back(std::make_unique<RenderFrameBuilder>(config_, hrtf));
    input_.listeners.resize(settings.listeners);
    for (const SourceState& source : room_state(scene, 0).sources)
        voices_.push_back(make_voice(source));
}

FrameMaker::Voice FrameMaker::make_voice(const SourceState& source) const {
    return {source,
            std::make_unique<ImpulseResponseBuilder>(carriers_, propagation_.response_length_s(),
                                                     source.name, field_order(config_)),
            std::vector<ImpulseResponse>(builders_.size())};
}

int FrameMaker::rays_wanted(const RoomState& room) const {
    if (room.frame_share && frame_s_ > 0)
        return rays_within_budget(rays_, statistics(), frame_s_,
                                  *room.frame_share * config_.frame_s);
    return room.rays.value_or(simulation_.rays);
}

/// Adds and removes voices to match the sources.
void FrameMaker::take_sources(const std::vector<SourceState>& sources) {
    const auto find = [&](std::uint64_t id) {
        return std::find_if(sources.begin(), sources.end(),
                            [&](const SourceState& source) { return source.id == id; });
    };
    for (std::size_t v = voices_.size(); v-- > 0;) {
        const auto source = find(voices_[v].state.id);
        if (source != sources.end() && !source->removed_at) continue;
        propagation_.remove_source(v);
        if (source != sources.end()) ringing_.push_back(std::move(voices_[v]));
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
    for (const Voice& voice : voices_) {
        input_.sources.push_back(voice.state.pose.position);
        input_.source_rotations.push_back(voice.state.pose.rotation());
    }
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
        voices_[v].impulse_responses->build(propagation_.response(v), voices_[v].responses[0]);
}

/// The newest response of a voice, with the gains applied.
SourceSound FrameMaker::sound_of(const Voice& voice, std::size_t listener,
                                 const RoomState& room) const {
    return source_sound(voice.responses[listener], static_cast<double>(speed_of_sound_m_s_),
                        voice.state.gain_db, room.direct_gain, room.early_gain);
}

void FrameMaker::fill(const RoomState& room, std::span<const std::unique_ptr<RenderFrame>> frames) {
    const auto begin = std::chrono::steady_clock::now();
    propagate(room);
    for (std::vector<SourceSound>& of_listener : sounds_)
        std::fill(of_listener.begin(), of_listener.end(), absent_sound());
    const std::vector<std::uint64_t> before =
        std::exchange(slot_sources_, std::vector<std::uint64_t>(slot_sources_.size()));
    // Whether a voice may be in the frame. A slot is absent for a frame between two sources, so
    // that neither is heard through the response of the other.
    const auto has_slot = [&](const Voice& voice) {
        const std::uint64_t last = before[voice.state.slot];
        if (last != 0 && last != voice.state.id) return false;
        slot_sources_[voice.state.slot] = voice.state.id;
        return true;
    };
    for (std::size_t l = 0; l < frames.size(); ++l) {
        for (const Voice& voice : ringing_)
            if (has_slot(voice)) sounds_[l][voice.state.slot] = sound_of(voice, l, room);
        for (std::size_t v = 0; v < voices_.size(); ++v) {
            Voice& voice = voices_[v];
            ImpulseResponse& response = voice.responses[l];
            voice.impulse_responses->build(propagation_.response(v, l), response);
            if (room.late_gain != 1) {
                for (std::vector<float>& channel : response.channels)
                    for (float& sample : channel) sample *= room.late_gain;
            }
            if (has_slot(voice)) sounds_[l][voice.state.slot] = sound_of(voice, l, room);
        }
        builders_[l]->prepare(sounds_[l], *frames[l]);
    }
    frame_s_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

double FrameMaker::longest_delay_s(std::uint64_t id) const {
    float longest_m = 0;
    for (const std::vector<Voice>* const voices : {&voices_, &ringing_}) {
        for (const Voice& voice : *voices) {
            if (voice.state.id != id) continue;
            for (const ImpulseResponse& response : voice.responses)
                for (const SpecularPath& path : response.paths)
                    longest_m = std::max(longest_m, path.length_m);
        }
    }
    return std::min(config_.longest_delay_s, static_cast<double>(longest_m / speed_of_sound_m_s_));
}

const SourceSound* FrameMaker::sound(std::uint64_t id, std::size_t listener) const {
    for (const Voice& voice : voices_)
        if (voice.state.id == id) return &sounds_[listener][voice.state.slot];
    return nullptr;
}

bool FrameMaker::visible(std::uint64_t id, std::size_t listener) const {
    const auto is_straight = [](const SpecularPath& path) {
        return path.order == 0 && path.edges == 0 && path.id == 0;
    };
    for (const Voice& voice : voices_) {
        if (voice.state.id != id) continue;
        const std::vector<SpecularPath>& paths = voice.responses[listener].paths;
        return std::any_of(paths.begin(), paths.end(), is_straight);
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
    const std::vector<float>& pressure = voices_[view.source].responses[0].channels[0];
    for (std::size_t i = 0; i < pressure.size(); ++i) {
        float& column = view.impulse_response[i * request.columns / pressure.size()];
        column = std::max(column, std::abs(pressure[i]));
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
