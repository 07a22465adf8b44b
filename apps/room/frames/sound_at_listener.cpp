#include "apps/room/frames/sound_at_listener.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

#include "audio/base/assume_nonblocking.h"
#include "engine/scene/air.h"
#include "engine/scene/scene_positions.h"

namespace aula {

namespace {

DiscretePath discrete_path(const SoundPath& path, double delay_s, float gain) {
    DiscretePath out;
    out.delay_s = delay_s;
    out.length_m = path.length_m;
    out.id = path.key;
    out.direction = {path.direction.x, path.direction.y, path.direction.z};
    for (std::size_t band = 0; band < kBandCount; ++band)
        out.band_gain[band] = gain * std::sqrt(squared_pressure(path.energy[band]));
    return out;
}

/// Interpolates by `share` from one angle to another in the shorter direction.
float towards(float from_rad, float to_rad, float share) {
    constexpr float kTurn_rad = 2 * std::numbers::pi_v<float>;
    return from_rad + share * std::remainder(to_rad - from_rad, kTurn_rad);
}

/// Additional length for the filters' decay after the last arrival.
constexpr double kFilterTail_s = 0.05;

}  // namespace

SourceSound source_sound(const ImpulseResponse& response, double speed_of_sound_m_s, float gain_db,
                         float direct_gain, float early_gain, const SourceTrajectory* trajectory) {
    SourceSound sound;
    for (std::size_t channel = 0; channel < response.channels.size(); ++channel)
        sound.ambisonics[channel] = response.channels[channel];
    for (const SoundPath& path : response.paths) {
        const float gain = path.order == 0 ? direct_gain : early_gain;
        const double delay_s = trajectory != nullptr ? trajectory->delay_s(path, speed_of_sound_m_s)
                                                     : double{path.length_m} / speed_of_sound_m_s;
        const DiscretePath discrete = discrete_path(path, delay_s, gain);
        if (path.is_main)
            sound.direct = discrete;
        else
            sound.early.push_back(discrete);
    }
    sound.gain = static_cast<float>(std::pow(10, double{gain_db} / 20));
    return sound;
}

double longest_delay_s(const Scene& scene) {
    Bounds bounds;
    bounds.add(scene_positions(scene));
    constexpr float kMargin_m = 1000;
    return static_cast<double>((bounds.diagonal_m() + kMargin_m) /
                               scene.medium.speed_of_sound_m_s());
}

RendererConfig renderer_config(const Scene& scene, double response_length_s,
                               const FrameSettings& settings) {
    AirAttenuation air;
    if (scene.medium.air_absorption)
        air = [medium = scene.medium](double frequency_hz) {
            return air_attenuation_per_m(medium, frequency_hz);
        };
    RendererConfig config{settings};
    config.sources = std::max(settings.max_sources, scene.sources.size());
    config.response_samples =
        static_cast<std::size_t>(std::ceil(response_length_s * settings.sample_rate_hz));
    config.frame_s = 1.0 / static_cast<double>(scene.simulation.frame_rate_hz);
    config.longest_delay_s = longest_delay_s(scene);
    config.air = air;
    return config;
}

ResponseRenderer::ResponseRenderer(RendererConfig config, double length_s,
                                   std::shared_ptr<const Hrtf> hrtf)
    : config_((config.sources = 1, std::move(config))),
      length_s_(length_s),
      hrtf_(std::move(hrtf)),
      frames_(config_, hrtf_) {}

std::vector<std::vector<float>> ResponseRenderer::response(const SourceSound& sound,
                                                           const Pose& head) {
    const FlushDenormals flush;
    const double rate_hz = config_.sample_rate_hz;
    const HeadRotation rotation = head_rotation(head);
    Renderer renderer(config_, hrtf_);
    frames_.restart();
    auto frame = frames_.make_frame();
    frames_.prepare({&sound, 1}, *frame);
    renderer.mailbox().publish(std::move(frame));

    auto length = static_cast<std::size_t>(std::ceil(length_s_ * rate_hz));
    if (sound.direct && sound.direct->delay_s > length_s_ - kFilterTail_s)
        length = std::max(
            length, static_cast<std::size_t>((sound.direct->delay_s + kFilterTail_s) * rate_hz));
    const auto block = static_cast<std::size_t>(config_.block);
    const std::size_t blocks = (length + block - 1) / block;
    std::vector<std::vector<float>> channels(channel_count(config_.output),
                                             std::vector<float>(blocks * block));
    std::vector<float> input(block);
    input[0] = 1;
    std::vector<float*> outputs;
    outputs.reserve(channels.size());
    for (std::size_t first = 0; first < length; first += block) {
        outputs.clear();
        for (auto& channel : channels) outputs.push_back(channel.data() + first);
        const std::array<const float*, 1> inputs{input.data()};
        renderer.render(inputs, rotation, outputs, config_.block);
        input[0] = 0;
    }
    for (auto& channel : channels) channel.resize(length);
    return channels;
}

HeadRotation head_rotation(const Pose& pose) noexcept {
    // Arithmetic; its columns are the head's axes.
    const glm::mat3 to_world = assume_nonblocking([&] { return pose.rotation(); });
    HeadRotation rotation;
    for (int axis = 0; axis < 3; ++axis)
        rotation[static_cast<std::size_t>(axis)] = {to_world[axis].x, to_world[axis].y,
                                                    to_world[axis].z};
    return rotation;
}

void HeadMotion::turn_to(const Pose& pose) noexcept {
    if (remaining_samples_ < 0) {
        now_ = pose;
        since_samples_ = frame_samples_;
    }
    target_ = pose;
    remaining_samples_ = since_samples_;
    since_samples_ = 0;
}

HeadRotation HeadMotion::advance(int samples) noexcept {
    if (remaining_samples_ < 0) return kNoRotation;
    since_samples_ = std::min(since_samples_ + samples, frame_samples_);
    const float share = remaining_samples_ <= samples
                            ? 1.0F
                            : static_cast<float>(samples) / static_cast<float>(remaining_samples_);
    now_.yaw_rad = towards(now_.yaw_rad, target_.yaw_rad, share);
    now_.pitch_rad = towards(now_.pitch_rad, target_.pitch_rad, share);
    now_.roll_rad = towards(now_.roll_rad, target_.roll_rad, share);
    remaining_samples_ = std::max(0, remaining_samples_ - samples);
    return head_rotation(now_);
}

}  // namespace aula
