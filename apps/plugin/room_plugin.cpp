#include "apps/plugin/room_plugin.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include "audio/base/mute.h"

namespace aula::plugin {

namespace {

/// Fade from one room to the next, as of another change of a scene that plays.
constexpr double kRoomFade_s = 0.05;

/// Time in which the wet share moves to a new value: the largest step of a sample is -67 dB.
constexpr double kWetGlide_s = 0.05;

std::size_t to_samples(double seconds, double sample_rate_hz) {
    return static_cast<std::size_t>(std::lround(seconds * sample_rate_hz));
}

}  // namespace

RoomPlugin::RoomPlugin(const Layout& layout, double sample_rate_hz, int block,
                       const LV2_URID_Map* map)
    : output_(layout.output),
      channels_(channel_count(layout.output)),
      messages_(map),
      loader_({layout.output, sample_rate_hz, block}),
      outputs_(channels_),
      fade_(to_samples(kRoomFade_s, sample_rate_hz)),
      wet_(to_samples(kWetGlide_s, sample_rate_hz)),
      ringing_outputs_(channels_, std::vector<float>(kChunk)),
      chunk_outputs_(channels_) {
    for (std::size_t i = 0; i < kControls; ++i) values_[i] = control_ports()[i].initial;
    for (std::vector<float>& channel : ringing_outputs_)
        ringing_pointers_.push_back(channel.data());
}

RoomPlugin::~RoomPlugin() { give_back_rooms(); }

void RoomPlugin::connect(std::uint32_t port, void* data) {
    const std::size_t first_control = control_port(output_, 0);
    if (port == kInputPort) {
        input_ = static_cast<const float*>(data);
    } else if (port < first_control) {
        outputs_[port - 1] = static_cast<float*>(data);
    } else if (port < first_control + kControls) {
        controls_[port - first_control] = static_cast<float*>(data);
    } else if (port == first_control + kControls) {
        control_ = static_cast<const LV2_Atom_Sequence*>(data);
    } else {
        notify_ = static_cast<LV2_Atom_Sequence*>(data);
    }
}

void RoomPlugin::activate() {
    started_ = false;
    rolls_ = false;
    is_open_ = false;
    read_controls();
    // A host that only renders needs no room in real time.
    is_open_ = !freewheels();
    if (is_open_) loader_.open();
}

void RoomPlugin::deactivate() {
    give_back_rooms();
    loader_.close();
    // One that was built meanwhile.
    if (PluginRoom* const room = loader_.take()) loader_.give_back(room);
}

void RoomPlugin::give_back_rooms() {
    for (PluginRoom* const room :
         {std::exchange(current_, nullptr), std::exchange(ringing_, nullptr), loader_.take()})
        if (room != nullptr) loader_.give_back(room);
    loader_.discard(std::move(exact_));
}

LV2_State_Status RoomPlugin::save(LV2_State_Store_Function store, LV2_State_Handle handle,
                                  const LV2_Feature* const* features) const {
    return messages_.save(loader_.files(), store, handle, features);
}

void RoomPlugin::restore(LV2_State_Retrieve_Function retrieve, LV2_State_Handle handle,
                         const LV2_Feature* const* features) {
    loader_.set_files(messages_.restore(loader_.files(), retrieve, handle, features));
    is_restored_ = true;
}

void RoomPlugin::run(std::uint32_t samples) {
    read_controls();
    messages_.begin(control_, notify_);
    std::int64_t done = 0;
    while (const auto event = messages_.next()) {
        const std::int64_t at = std::clamp<std::int64_t>(event->offset, done, samples);
        process(done, at);
        done = at;
        handle(*event);
    }
    process(done, samples);
    send_replies();
    messages_.end();
    if (float* const latency = controls_[static_cast<std::size_t>(Control::latency)]) *latency = 0;
}

void RoomPlugin::read_controls() {
    for (std::size_t i = 0; i < kControls; ++i)
        if (controls_[i] != nullptr && !control_ports()[i].output)
            values_[i] = valid(static_cast<Control>(i), *controls_[i]);
    loader_.controls().write(values_);
    const float group = std::round(value_of(values_, Control::room_group));
    if (std::exchange(group_, group) != group && is_open_) loader_.request_another();
    const auto wet = static_cast<double>(target_wet());
    if (wet != wet_.target()) wet_.move_to(wet);
}

float RoomPlugin::target_wet() const {
    return value_of(values_, Control::enabled) > 0.5F ? value_of(values_, Control::wet) : 0;
}

void RoomPlugin::handle(const HostEvent& event) {
    switch (event.kind) {
        case HostEvent::Kind::set:
            loader_.request(event.property, event.text);
            loader_.discard(std::move(exact_));
            break;
        case HostEvent::Kind::get:
            loader_.request_replies();
            break;
        case HostEvent::Kind::position: {
            const bool rolled = std::exchange(rolls_, event.speed != 0);
            const bool jumps = rolls_ && (!rolled || event.frame != transport_);
            transport_ = event.frame;
            if (jumps && !is_fresh_) loader_.discard(std::move(exact_));
            break;
        }
    }
}

/// Starts a room on the exact clock.
void RoomPlugin::begin_exact() {
    exact_ = loader_.exact_room();
    is_fresh_ = true;
    started_ = false;
}

void RoomPlugin::process(std::int64_t first, std::int64_t last) {
    if (is_restored_.exchange(false)) loader_.discard(std::move(exact_));
    if (!freewheels()) {
        loader_.discard(std::move(exact_));
        if (!std::exchange(is_open_, true)) loader_.request_open();
    }
    for (; first < last; first += static_cast<std::int64_t>(kChunk)) {
        const auto samples = static_cast<std::size_t>(std::min<std::int64_t>(kChunk, last - first));
        if (freewheels() && !exact_) begin_exact();
        if (!std::exchange(started_, true)) wet_.jump(static_cast<double>(target_wet()));
        // A copy: the outputs may be the same memory.
        std::copy_n(input_ + first, samples, dry_.begin());
        if (const std::size_t muted = mute_beyond(kLargestSample, std::span(dry_).first(samples));
            muted > 0)
            loader_.count_muted(muted);
        for (std::size_t c = 0; c < channels_; ++c) chunk_outputs_[c] = outputs_[c] + first;
        if (freewheels())
            render_exact(chunk_outputs_, samples);
        else
            render_live(chunk_outputs_, samples);
        mix(chunk_outputs_, samples);
        if (rolls_) transport_ += static_cast<std::int64_t>(samples);
    }
}

/// Silence without a room, or after its failure.
void RoomPlugin::render_exact(std::span<float* const> outputs, std::size_t samples) {
    is_fresh_ = false;
    try {
        if (exact_) {
            exact_->set_controls(values_);
            return exact_->render(dry_.data(), outputs, static_cast<int>(samples));
        }
    } catch (const std::exception&) {
        loader_.discard(std::move(exact_));
    }
    for (float* const channel : outputs) std::fill_n(channel, samples, 0.0F);
}

/// The present room's sound. The input of a new room fades in while that of the room before it
/// fades out and rings out.
void RoomPlugin::render_live(std::span<float* const> outputs, std::size_t samples) {
    if (ringing_ == nullptr) {
        if (PluginRoom* const room = loader_.take()) {
            ringing_ = std::exchange(current_, room);
            if (ringing_ != nullptr) {
                fade_.start();
                ringing_samples_ =
                    static_cast<std::int64_t>(fade_.remaining()) + ringing_->tail_samples();
            }
        }
    }
    if (current_ == nullptr) {
        for (float* const channel : outputs) std::fill_n(channel, samples, 0.0F);
        return;
    }
    std::copy_n(dry_.begin(), samples, room_input_.begin());
    fade_.fade_in(std::span(room_input_).first(samples));
    current_->render(room_input_.data(), outputs, static_cast<int>(samples));
    if (ringing_ == nullptr) return;
    std::copy_n(dry_.begin(), samples, room_input_.begin());
    fade_.fade_out(std::span(room_input_).first(samples));
    fade_.advance(samples);
    ringing_->render(room_input_.data(), ringing_pointers_, static_cast<int>(samples));
    for (std::size_t c = 0; c < channels_; ++c)
        for (std::size_t n = 0; n < samples; ++n) outputs[c][n] += ringing_outputs_[c][n];
    ringing_samples_ -= static_cast<std::int64_t>(samples);
    if (ringing_samples_ <= 0) loader_.give_back(std::exchange(ringing_, nullptr));
}

/// Mixes the input in: at both ears, or in the omnidirectional channel of ambisonics.
void RoomPlugin::mix(std::span<float* const> outputs, std::size_t samples) {
    bool is_wet = true;
    for (std::size_t n = 0; n < samples; ++n) {
        weights_[n] = static_cast<float>(wet_.next());
        is_wet = is_wet && weights_[n] == 1;
    }
    if (is_wet) return;
    const std::size_t dry_channels = output_ == OutputFormat::binaural ? 2 : 1;
    for (std::size_t c = 0; c < outputs.size(); ++c) {
        for (std::size_t n = 0; n < samples; ++n) {
            outputs[c][n] *= weights_[n];
            if (c < dry_channels) outputs[c][n] += (1 - weights_[n]) * dry_[n];
        }
    }
}

void RoomPlugin::send_replies() {
    MessageQueue& replies = loader_.replies();
    while (const Message* const reply = replies.front()) {
        if (!messages_.send(*reply)) break;
        replies.pop();
    }
}

}  // namespace aula::plugin
