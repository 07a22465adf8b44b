#include "aula/devices/microphone.h"

#include <algorithm>
#include <vector>

#include "audio/device/capture_buffer.h"
#include "audio/device/output.h"

namespace aula {

struct Microphone::State {
    State(const DeviceInfo& output, double sample_rate_hz, int block)
        : buffer(sample_rate_hz, block), samples(static_cast<std::size_t>(block)) {
        const InputSettings settings{
            sample_rate_hz, block,
            [this](std::span<const float> captured) { buffer.write(captured); }};
        input = output.host_api == "JACK" ? open_jack_input(settings)
                                          : open_port_audio_input(output, settings);
    }

    CaptureBuffer buffer;
    std::vector<float> samples;  ///< the block at `position`
    std::int64_t position = -1;
    std::unique_ptr<Input> input;  ///< destroyed before the buffer that it fills
};

Microphone::Microphone(const DeviceInfo& output, double sample_rate_hz, int block)
    : state_(std::make_unique<State>(output, sample_rate_hz, block)) {}

Microphone::~Microphone() = default;

void Microphone::read(std::int64_t position, std::span<float> out) noexcept {
    const std::span<float> samples = std::span(state_->samples).first(out.size());
    if (position != state_->position) {
        state_->position = position;
        state_->buffer.read(samples);
    }
    std::copy(samples.begin(), samples.end(), out.begin());
}

const std::string& Microphone::name() const { return state_->input->name(); }

bool Microphone::alive() const { return state_->input->alive(); }

}  // namespace aula
