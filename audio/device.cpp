#include "audio/device.h"

#include <alsa/asoundlib.h>
#include <jack/jack.h>
#include <portaudio.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "audio/error.h"
#include "audio/realtime.h"

namespace aula {

namespace {

using Clock = std::chrono::steady_clock;

constexpr double kLoadSmoothing_s = 0.5;
constexpr std::chrono::milliseconds kSilenceOfLostDevice{1000};

// Some servers report latencies of minutes; no buffer that is worth using is longer than this.
constexpr double kLongestLatency_s = 0.1;

constexpr const char* kNoDevice =
    "no audio output device (no sound server or card); render to a file with --offline OUT.wav";

void ignore_alsa(const char*, int, const char*, int, const char*, ...) {}
void ignore_jack(const char*) {}

/// PortAudio, initialised while alive, without the chatter of the libraries below it.
class PortAudio {
 public:
    PortAudio() {
        snd_lib_error_set_handler(ignore_alsa);
        jack_set_error_function(ignore_jack);
        jack_set_info_function(ignore_jack);
        setenv("JACK_NO_START_SERVER", "1", 0);
        const PaError error = Pa_Initialize();
        if (error != paNoError) {
            throw AudioFailure(std::string("audio cannot be initialised: ") +
                               Pa_GetErrorText(error));
        }
    }
    ~PortAudio() { Pa_Terminate(); }
    PortAudio(const PortAudio&) = delete;
    PortAudio& operator=(const PortAudio&) = delete;

    std::vector<DeviceInfo> outputs() const {
        std::vector<DeviceInfo> devices;
        for (int i = 0; i < Pa_GetDeviceCount(); ++i) {
            const PaDeviceInfo& device = *Pa_GetDeviceInfo(i);
            if (device.maxOutputChannels <= 0) continue;
            devices.push_back({i, device.name, Pa_GetHostApiInfo(device.hostApi)->name,
                               device.maxOutputChannels, device.defaultSampleRate,
                               std::clamp(device.defaultHighOutputLatency, 0.0, kLongestLatency_s),
                               i == Pa_GetDefaultOutputDevice()});
        }
        return devices;
    }
};

std::string lower(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

std::string listed(const std::vector<DeviceInfo>& devices) {
    std::string text;
    for (const DeviceInfo& device : devices) {
        if (!text.empty()) text += ", ";
        text += std::to_string(device.index) + " \"" + device.name + "\" (" + device.host_api + ")";
    }
    return text;
}

DeviceInfo choose(const std::vector<DeviceInfo>& devices, const std::string& wanted) {
    if (devices.empty()) throw AudioFailure(kNoDevice);
    if (wanted.empty()) {
        const auto found = std::find_if(devices.begin(), devices.end(),
                                        [](const DeviceInfo& d) { return d.is_default; });
        return found == devices.end() ? devices.front() : *found;
    }
    std::vector<DeviceInfo> matches;
    for (const DeviceInfo& device : devices) {
        if (wanted == std::to_string(device.index) || lower(wanted) == lower(device.name)) {
            return device;
        }
        if (lower(device.name).find(lower(wanted)) != std::string::npos) matches.push_back(device);
    }
    if (matches.empty()) {
        throw AudioInputError("audio device \"" + wanted +
                              "\": no such output; expected the index or a part of the name of " +
                              listed(devices));
    }
    if (matches.size() > 1) {
        throw AudioInputError("audio device \"" + wanted +
                              "\": matches several outputs; expected one of " + listed(matches));
    }
    return matches.front();
}

std::string hertz(double rate_hz) { return std::to_string(std::lround(rate_hz)) + " Hz"; }

}  // namespace

std::vector<DeviceInfo> list_output_devices() { return PortAudio().outputs(); }

struct AudioDevice::State {
    PortAudio port_audio;
    DeviceInfo info;
    Callback callback;
    std::size_t channels = 0;
    double sample_rate_hz = 0;
    PaStream* stream = nullptr;
    bool started = false;

    std::atomic<std::uint64_t> underruns{0};
    std::atomic<double> load{0};
    std::atomic<double> worst_load{0};
    std::atomic<Clock::rep> last_call{0};
    std::atomic<bool> abandoned{false};
    static_assert(std::atomic<double>::is_always_lock_free);

    ~State() {
        if (stream != nullptr) Pa_CloseStream(stream);
    }

    bool active() const {
        if (!started || Pa_IsStreamActive(stream) != 1) return false;
        // Not every server says good-bye.
        const Clock::duration silence{Clock::now().time_since_epoch().count() - last_call.load()};
        return silence < kSilenceOfLostDevice;
    }

    /// [audio thread, wait-free]
    void fill(float* const* outputs, unsigned long samples,
              PaStreamCallbackFlags flags) noexcept AULA_NONBLOCKING {
        const FlushDenormals flush;
        const Clock::time_point start = Clock::now();
        if (abandoned.load(std::memory_order_acquire)) {
            for (std::size_t c = 0; c < channels; ++c) std::fill_n(outputs[c], samples, 0.0F);
            return;
        }
        if ((flags & paOutputUnderflow) != 0) underruns.fetch_add(1, std::memory_order_relaxed);
        callback({outputs, channels}, static_cast<int>(samples));

        const Clock::time_point end = Clock::now();
        const double block_s = static_cast<double>(samples) / sample_rate_hz;
        const double now = std::chrono::duration<double>(end - start).count() / block_s;
        const double before = load.load(std::memory_order_relaxed);
        load.store(before + std::min(1.0, block_s / kLoadSmoothing_s) * (now - before),
                   std::memory_order_relaxed);
        if (now > worst_load.load(std::memory_order_relaxed)) {
            worst_load.store(now, std::memory_order_relaxed);
        }
        last_call.store(end.time_since_epoch().count(), std::memory_order_relaxed);
    }

    static int call(const void*, void* output, unsigned long samples,
                    const PaStreamCallbackTimeInfo*, PaStreamCallbackFlags flags, void* user) {
        static_cast<State*>(user)->fill(static_cast<float* const*>(output), samples, flags);
        return paContinue;
    }

    [[noreturn]] void fail(const std::string& what, PaError error) const {
        std::string why = Pa_GetErrorText(error);
        if (error == paUnanticipatedHostError) {
            const PaHostErrorInfo* const host = Pa_GetLastHostErrorInfo();
            if (host != nullptr && host->errorText != nullptr) why = host->errorText;
        }
        throw AudioFailure("audio device \"" + info.name + "\": " + what + ": " + why);
    }
};

AudioDevice::AudioDevice(const std::string& wanted, double sample_rate_hz, std::size_t channels,
                         int block, Callback callback)
    : state_(std::make_unique<State>()) {
    State& s = *state_;
    s.info = choose(s.port_audio.outputs(), wanted);
    s.callback = std::move(callback);
    s.channels = channels;
    s.sample_rate_hz = sample_rate_hz;
    if (static_cast<std::size_t>(s.info.output_channels) < channels) {
        throw AudioFailure("audio device \"" + s.info.name + "\": has " +
                           std::to_string(s.info.output_channels) + " output channels; needed " +
                           std::to_string(channels));
    }

    PaStreamParameters output{};
    output.device = s.info.index;
    output.channelCount = static_cast<int>(channels);
    output.sampleFormat = paFloat32 | paNonInterleaved;
    output.suggestedLatency = std::max(s.info.latency_s, block / sample_rate_hz);
    const PaError error =
        Pa_OpenStream(&s.stream, nullptr, &output, sample_rate_hz,
                      static_cast<unsigned long>(block), paNoFlag, &State::call, &s);
    if (error == paInvalidSampleRate) {
        s.stream = nullptr;
        throw SampleRateRefused("audio device \"" + s.info.name + "\": plays at " +
                                    hertz(s.info.sample_rate_hz) + ", not at " +
                                    hertz(sample_rate_hz) + "; give --sample-rate",
                                s.info.sample_rate_hz);
    }
    if (error != paNoError) {
        s.stream = nullptr;
        s.fail("cannot be opened", error);
    }
    const PaStreamInfo* const stream = Pa_GetStreamInfo(s.stream);
    if (stream != nullptr && stream->outputLatency > 0 &&
        stream->outputLatency <= kLongestLatency_s) {
        s.info.latency_s = stream->outputLatency;
    }
}

AudioDevice::~AudioDevice() {
    stop();
    if (state_->abandoned) static_cast<void>(state_.release());
}

void AudioDevice::start() {
    State& s = *state_;
    if (s.started) return;
    if (s.abandoned) throw AudioFailure("audio device \"" + s.info.name + "\": was lost");
    s.last_call = Clock::now().time_since_epoch().count();
    const PaError error = Pa_StartStream(s.stream);
    if (error != paNoError) s.fail("cannot be started", error);
    s.started = true;
}

void AudioDevice::stop() {
    State& s = *state_;
    if (!s.started) return;
    const bool lost = !s.active();
    s.started = false;
    if (!lost) {
        Pa_StopStream(s.stream);
        return;
    }
    // PortAudio would wait ten minutes for a server that is gone, and its threads may still hold
    // the stream: what belongs to it is left behind, and calls nobody any more.
    s.abandoned.store(true, std::memory_order_release);
}

const DeviceInfo& AudioDevice::info() const { return state_->info; }

bool AudioDevice::active() const { return state_->active(); }

std::uint64_t AudioDevice::underruns() const { return state_->underruns; }
double AudioDevice::load() const { return state_->load; }
double AudioDevice::worst_load() const { return state_->worst_load; }

}  // namespace aula
