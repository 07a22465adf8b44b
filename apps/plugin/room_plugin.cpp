#include "apps/plugin/room_plugin.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include "audio/base/mute.h"

namespace aula::plugin {

namespace {

/// Time in which the wet share moves to a new value: the largest step of a sample is -67 dB.
constexpr double kWetGlide_s = 0.05;

/// Fall of the level, dB/s: that of peak programme meters of type I (IEC 60268-10), 20 dB in 1.7 s.
constexpr double kLevelFall_db_s = 20 / 1.7;

}  // namespace

RoomPlugin::RoomPlugin(const PluginPorts& ports)
    : output_(ports.output),
      channels_(channel_count(ports.output)),
      sample_rate_hz_(ports.sample_rate_hz),
      loader_(ports),
      values_(initial_values()),
      rooms_(loader_, ports.sample_rate_hz, static_cast<int>(kChunk)),
      wet_(static_cast<std::size_t>(std::lround(kWetGlide_s * ports.sample_rate_hz))),
      dry_(ports.sources, std::vector<float>(kChunk)),
      room_input_(dry_),
      room_outputs_(channels_, std::vector<float>(kChunk)),
      chunk_outputs_(channels_) {
    for (std::vector<float>& channel : room_outputs_)
        room_output_pointers_.push_back(channel.data());
    for (const std::vector<float>& source : dry_) dry_pointers_.push_back(source.data());
    for (const std::vector<float>& source : room_input_)
        room_input_pointers_.push_back(source.data());
}

RoomPlugin::~RoomPlugin() { give_back_rooms(); }

void RoomPlugin::activate(const ControlValues& values, bool is_offline) {
    started_ = false;
    rolls_ = false;
    is_open_ = false;
    is_offline_ = is_offline;
    set_controls(values);
    is_open_ = !is_offline_;
    if (is_open_) loader_.open();
}

void RoomPlugin::deactivate() {
    give_back_rooms();
    loader_.close();
    // One that was built meanwhile.
    if (PluginRoom* const room = loader_.take()) loader_.give_back(room);
}

void RoomPlugin::give_back_rooms() {
    rooms_.clear();
    if (PluginRoom* const room = loader_.take()) loader_.give_back(room);
    loader_.discard(exact_.release());
}

void RoomPlugin::set_files(const RoomFiles& files) {
    loader_.set_files(files);
    is_restored_ = true;
}

void RoomPlugin::change_files(const RoomFiles& files) {
    loader_.change_files(files);
    is_restored_ = true;
}

void RoomPlugin::set_controls(const ControlValues& values) {
    for (std::size_t i = 0; i < kControls; ++i)
        values_[i] = valid(static_cast<Control>(i), values[i]);
    loader_.controls().write(values_);
    const float group = std::round(value_of(values_, Control::room_group));
    const float room = std::round(value_of(values_, Control::room));
    const bool has_other_room = std::exchange(room_, room) != room;
    const bool has_other_group = std::exchange(group_, group) != group;
    if (has_other_room) restart();
    if ((has_other_group || has_other_room) && is_open_) loader_.request_another();
    const auto wet = static_cast<double>(target_wet());
    if (wet != wet_.target()) wet_.move_to(wet);
}

void RoomPlugin::set_offline(bool is_offline) {
    is_offline_ = is_offline;
    if (is_offline_) return;
    restart();
    if (!std::exchange(is_open_, true)) loader_.request_open();
}

void RoomPlugin::restart() { loader_.discard(exact_.release()); }

bool RoomPlugin::request(Property property, std::string_view file) {
    restart();
    return loader_.request(property, file);
}

void RoomPlugin::move_transport(std::int64_t sample, bool rolls) {
    const bool rolled = std::exchange(rolls_, rolls);
    const bool jumps = rolls_ && (!rolled || sample != transport_);
    transport_ = sample;
    if (jumps && !is_fresh_) restart();
}

float RoomPlugin::target_wet() const {
    return value_of(values_, Control::enabled) > 0.5F ? value_of(values_, Control::wet) : 0;
}

/// Starts a room on the exact clock.
void RoomPlugin::begin_exact() {
    exact_ = loader_.exact_room();
    is_fresh_ = true;
    started_ = false;
}

void RoomPlugin::process(std::span<const float* const> inputs, std::span<float* const> outputs,
                         std::size_t first, std::size_t last) {
    if (is_restored_.exchange(false)) restart();
    for (; first < last; first += kChunk) {
        const std::size_t samples = std::min(kChunk, last - first);
        if (is_offline_ && !exact_) begin_exact();
        if (!std::exchange(started_, true)) wet_.jump(static_cast<double>(target_wet()));
        // A copy: the outputs may be the same memory.
        for (std::size_t s = 0; s < dry_.size(); ++s) {
            std::copy_n(inputs[s] + first, samples, dry_[s].begin());
            const std::span<float> source = std::span(dry_[s]).first(samples);
            if (const std::size_t muted = mute_beyond(kLargestSample, source); muted > 0)
                loader_.count_muted(muted);
        }
        for (std::size_t c = 0; c < channels_; ++c) chunk_outputs_[c] = outputs[c] + first;
        if (is_offline_)
            render_exact(samples);
        else
            render_live(samples);
        mix(samples);
        measure_level(samples);
        if (rolls_) transport_ += static_cast<std::int64_t>(samples);
    }
}

/// Silence without a room, or after its failure.
void RoomPlugin::render_exact(std::size_t samples) {
    is_fresh_ = false;
    try {
        if (exact_) {
            exact_->set_controls(values_);
            tail_samples_ = exact_->tail_samples();
            return exact_->render(dry_pointers_, chunk_outputs_, static_cast<int>(samples));
        }
    } catch (const std::exception&) {
        loader_.discard(exact_.release());
    }
    for (float* const channel : chunk_outputs_) std::fill_n(channel, samples, 0.0F);
}

/// The sound of the present room, and of those before it that ring out.
void RoomPlugin::render_live(std::size_t samples) {
    rooms_.advance();
    for (float* const channel : chunk_outputs_) std::fill_n(channel, samples, 0.0F);
    rooms_.render(
        static_cast<int>(samples), [&](PluginRoom& room, std::span<const float> input_weights,
                                       std::span<const float> output_weights) {
            for (std::size_t s = 0; s < dry_.size(); ++s) {
                std::copy_n(dry_[s].begin(), samples, room_input_[s].begin());
                apply_weights(input_weights, room_input_[s].data());
            }
            room.render(room_input_pointers_, room_output_pointers_, static_cast<int>(samples));
            for (std::size_t c = 0; c < channels_; ++c) {
                apply_weights(output_weights, room_output_pointers_[c]);
                for (std::size_t n = 0; n < samples; ++n)
                    chunk_outputs_[c][n] += room_outputs_[c][n];
            }
        });
    if (rooms_.playing() != nullptr) tail_samples_ = rooms_.tail_samples();
}

/// Mixes the inputs in: at the ears, a single one at both, or in the omnidirectional channel of
/// ambisonics, both of two.
void RoomPlugin::mix(std::size_t samples) {
    bool is_wet = true;
    for (std::size_t n = 0; n < samples; ++n) {
        weights_[n] = static_cast<float>(wet_.next());
        is_wet = is_wet && weights_[n] == 1;
    }
    if (is_wet) return;
    for (float* const channel : chunk_outputs_)
        for (std::size_t n = 0; n < samples; ++n) channel[n] *= weights_[n];
    const bool is_binaural = output_ == OutputFormat::binaural;
    const std::size_t pairs = is_binaural ? 2 : dry_.size();
    for (std::size_t p = 0; p < pairs; ++p) {
        float* const channel = chunk_outputs_[is_binaural ? p : 0];
        const std::vector<float>& source = dry_[std::min(p, dry_.size() - 1)];
        for (std::size_t n = 0; n < samples; ++n) channel[n] += (1 - weights_[n]) * source[n];
    }
}

void RoomPlugin::measure_level(std::size_t samples) {
    float peak = 0;
    for (const float* const channel : chunk_outputs_)
        for (std::size_t n = 0; n < samples; ++n) peak = std::max(peak, std::abs(channel[n]));
    const auto fall_db =
        static_cast<float>(kLevelFall_db_s * static_cast<double>(samples) / sample_rate_hz_);
    // Of a peak of 0, too.
    const float peak_db = std::max(20 * std::log10(peak), kSilence_db);
    level_db_ = std::max(level_db_ - fall_db, peak_db);
}

}  // namespace aula::plugin
