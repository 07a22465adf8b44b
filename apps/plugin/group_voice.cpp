#include "apps/plugin/group_voice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace aula::plugin {

namespace {

/// Time for which an instance is heard beyond its response: fades and the length of the filters.
constexpr double kRingTail_s = 0.1;

/// The source that the renderer plays, and the listener.
constexpr SourceId kVoiceSource{1};
constexpr std::size_t kListener = 0;

}  // namespace

GroupVoice::Dimensions GroupVoice::dimensions(const SharedRoom& room,
                                              const std::filesystem::path& hrtf,
                                              const PluginOutput& output) {
    const FrameSettings settings{.sample_rate_hz = output.sample_rate_hz,
                                 .block = output.block,
                                 .output = output.format,
                                 // Half the memory of the filters of sixteen channels.
                                 .half_precision_tail = output.format == OutputFormat::toa,
                                 .max_sources = 1};
    return {
        renderer_config(room.scene(), room.response_length_s(), settings),
        output.format == OutputFormat::binaural ? load_hrtf(hrtf, output.sample_rate_hz) : nullptr};
}

GroupVoice::GroupVoice(std::shared_ptr<SharedRoom> room, const std::filesystem::path& hrtf,
                       const PluginOutput& output, std::shared_ptr<const ControlSnapshot> controls,
                       std::function<void()> leave, ReportRays report)
    : GroupVoice(room, dimensions(*room, hrtf, output), std::move(controls), std::move(leave),
                 std::move(report)) {}

GroupVoice::GroupVoice(std::shared_ptr<SharedRoom> room, const Dimensions& dimensions,
                       std::shared_ptr<const ControlSnapshot> controls, std::function<void()> leave,
                       ReportRays report)
    : room_(std::move(room)),
      places_(room_->scene()),
      controls_(std::move(controls)),
      leave_(std::move(leave)),
      report_(std::move(report)),
      speed_of_sound_m_s_(static_cast<double>(room_->scene().medium.speed_of_sound_m_s())),
      rate_hz_(dimensions.config.sample_rate_hz),
      values_(controls_->read()),
      trajectory_(dimensions.config.longest_delay_s),
      responses_(make_noise_carriers(rate_hz_, room_->scene().simulation.seed),
                 room_->scene().medium, room_->response_length_s(), room_->scene().sources[0].name,
                 field_order(dimensions.config)),
      frames_(dimensions.config, dimensions.hrtf),
      tail_samples_(std::llround(
          (std::max(room_->response_length_s(), dimensions.config.longest_delay_s) + kRingTail_s) *
          rate_hz_)),
      block_(static_cast<std::size_t>(dimensions.config.block)),
      renderer_(dimensions.config, 1, dimensions.hrtf),
      head_pose_(places_.listener_pose(values_)),
      outputs_(channel_count(dimensions.config.output)) {
    renderer_.set_source(0, kVoiceSource);
    renderer_.turn_head(kListener, head_pose_);
    room_->add(*this);
}

GroupVoice::~GroupVoice() { room_->remove(*this); }

void GroupVoice::read_controls() { values_ = controls_->read(); }

void GroupVoice::begin_frame(double time_s) {
    read_controls();
    trajectory_.add(time_s, source().position, speed_of_sound_m_s_);
}

void GroupVoice::prepare(const EnergyResponse& energy) {
    // Not a member: the instances of a room are prepared one after the other in the same memory.
    ImpulseResponse response;
    responses_.build(energy, response);
    const PartGains gains = SceneControls::part_gains(values_);
    if (gains.late != 1) {
        for (std::vector<float>& channel : response.channels)
            for (float& sample : channel) sample *= gains.late;
    }
    longest_delay_s_ = 0;
    for (const SoundPath& path : response.paths)
        longest_delay_s_ =
            std::max(longest_delay_s_, trajectory_.delay_s(path, speed_of_sound_m_s_));
    if (!prepared_) prepared_ = renderer_.frames(kListener).reclaim();
    if (!prepared_) prepared_ = frames_.make_frame();
    const SourceSound sound = source_sound(response, speed_of_sound_m_s_, places_.gain_db(values_),
                                           gains.direct, gains.early, &trajectory_);
    frames_.prepare({&sound, 1}, *prepared_);
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

void GroupVoice::render(const float* input, std::span<float* const> outputs, int samples) {
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
        const std::array<SourceSignal, 1> inputs{SourceSignal{kVoiceSource, input + done}};
        renderer_.render(inputs, 0, {}, outputs_, static_cast<int>(part));
        done += part;
    }
}

}  // namespace aula::plugin
