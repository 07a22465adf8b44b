#include "apps/plugin/group_voice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "apps/room/base/output_resources.h"

namespace aula::plugin {

namespace {

/// Time for which an instance is heard beyond its response: fades and the length of the filters.
constexpr double kRingTail_s = 0.1;

constexpr std::size_t kListener = 0;

/// One for each source, which has carriers of its own.
std::vector<ImpulseResponseBuilder> response_builders(const SharedRoom& room, std::size_t sources,
                                                      const RendererConfig& config) {
    const Scene& scene = room.scene();
    std::vector<ImpulseResponseBuilder> builders;
    for (std::size_t s = 0; s < sources; ++s)
        builders.emplace_back(make_noise_carriers(config.sample_rate_hz, scene.simulation.seed),
                              scene.medium, room.response_length_s(),
                              scene.sources[0].name + (s == 0 ? "" : " " + std::to_string(s + 1)),
                              field_order(config));
    return builders;
}

}  // namespace

GroupVoice::Dimensions GroupVoice::dimensions(const SharedRoom& room, const PluginPorts& ports) {
    FrameSettings settings{ports};
    // Half the memory of the filters of sixteen channels.
    settings.half_precision_tail = ports.output == OutputFormat::toa;
    settings.max_sources = ports.sources;
    return {renderer_config(room.scene(), room.response_length_s(), settings), hrtf_for(settings)};
}

GroupVoice::GroupVoice(std::shared_ptr<SharedRoom> room, const PluginPorts& ports,
                       std::shared_ptr<const ControlSnapshot> controls, std::function<void()> leave,
                       ReportRays report)
    : GroupVoice(room, dimensions(*room, ports), std::move(controls), std::move(leave),
                 std::move(report)) {}

GroupVoice::GroupVoice(std::shared_ptr<SharedRoom> room, const Dimensions& dimensions,
                       std::shared_ptr<const ControlSnapshot> controls, std::function<void()> leave,
                       ReportRays report)
    : room_(std::move(room)),
      places_(room_->scene(), dimensions.config.sources),
      controls_(std::move(controls)),
      leave_(std::move(leave)),
      report_(std::move(report)),
      speed_of_sound_m_s_(static_cast<double>(room_->scene().medium.speed_of_sound_m_s())),
      rate_hz_(dimensions.config.sample_rate_hz),
      values_(controls_->read()),
      trajectories_(sources(), SourceTrajectory(dimensions.config.longest_delay_s)),
      responses_(response_builders(*room_, sources(), dimensions.config)),
      synthesis_(rate_hz_, responses_[0].length_samples()),
      frames_(dimensions.config, dimensions.hrtf),
      tail_samples_(std::llround(
          (std::max(room_->response_length_s(), dimensions.config.longest_delay_s) + kRingTail_s) *
          rate_hz_)),
      block_(static_cast<std::size_t>(dimensions.config.block)),
      renderer_(dimensions.config, 1, dimensions.hrtf),
      head_pose_(places_.listener_pose(values_)),
      outputs_(channel_count(dimensions.config.output)) {
    for (std::size_t s = 0; s < sources(); ++s) renderer_.set_source(s, source_id(s));
    renderer_.turn_head(kListener, head_pose_);
    room_->add(*this);
}

GroupVoice::~GroupVoice() { room_->remove(*this); }

void GroupVoice::read_controls() { values_ = controls_->read(); }

void GroupVoice::begin_frame(double time_s) {
    read_controls();
    for (std::size_t s = 0; s < sources(); ++s)
        trajectories_[s].add(time_s, source(s).position, speed_of_sound_m_s_);
}

void GroupVoice::prepare(std::span<const Arriving> arriving) {
    // Not members: the instances of a room are prepared one after the other in the same memory.
    std::array<ImpulseResponse, kMostSources> responses;
    std::array<SourceSound, kMostSources> sounds;
    const PartGains gains = SceneControls::part_gains(values_);
    longest_delay_s_ = 0;
    for (std::size_t s = 0; s < arriving.size(); ++s) {
        const SourceTrajectory& trajectory = trajectories_[s];
        ImpulseResponse& response = responses[s];
        synthesis_.build(
            responses_[s], *arriving[s].energy, arriving[s].modes,
            [&](const SoundPath& path) { return trajectory.delay_s(path, speed_of_sound_m_s_); },
            response);
        if (gains.late != 1) {
            for (std::vector<float>& channel : response.channels)
                for (float& sample : channel) sample *= gains.late;
        }
        for (const SoundPath& path : response.paths)
            longest_delay_s_ =
                std::max(longest_delay_s_, trajectory.delay_s(path, speed_of_sound_m_s_));
        sounds[s] = source_sound(response, speed_of_sound_m_s_, places_.gain_db(values_),
                                 gains.direct, gains.early, &trajectory);
    }
    if (!prepared_) prepared_ = renderer_.frames(kListener).reclaim();
    if (!prepared_) prepared_ = frames_.make_frame();
    frames_.prepare(std::span(sounds).first(arriving.size()), *prepared_);
}

void GroupVoice::publish() {
    if (!prepared_) return;
    renderer_.frames(kListener).publish(std::move(prepared_));
    heard_ = true;
    tail_samples_ = std::llround(
        (std::max(room_->response_length_s(), longest_delay_s_) + kRingTail_s) * rate_hz_);
}

void GroupVoice::leave() {
    if (!std::exchange(leaves_, true)) leave_();
}

void GroupVoice::render(std::span<const float* const> inputs, std::span<float* const> outputs,
                        int samples) {
    const FlushDenormals flush;
    const Pose pose = places_.listener_pose(controls_->read());
    if (pose.yaw_rad != head_pose_.yaw_rad || pose.pitch_rad != head_pose_.pitch_rad ||
        pose.roll_rad != head_pose_.roll_rad) {
        renderer_.turn_head(kListener, pose);
        head_pose_ = pose;
    }
    const auto count = static_cast<std::size_t>(samples);
    for (std::size_t done = 0; done < count;) {
        const std::size_t part = std::min(block_, count - done);
        for (std::size_t c = 0; c < outputs_.size(); ++c) outputs_[c] = outputs[c] + done;
        std::array<SourceSignal, kMostSources> signals;
        for (std::size_t s = 0; s < inputs.size(); ++s)
            signals[s] = {source_id(s), inputs[s] + done};
        renderer_.render(std::span(signals).first(inputs.size()), 0, {}, outputs_,
                         static_cast<int>(part));
        done += part;
    }
}

}  // namespace aula::plugin
