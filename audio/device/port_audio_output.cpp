#include <alsa/asoundlib.h>
#include <dlfcn.h>
#include <pa_linux_alsa.h>
#include <portaudio.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <utility>

#include "audio/device/output.h"
#include "audio/device/sound_libraries.h"
#include "aula/audio/realtime.h"
#include "aula/exception.h"

// What PortAudio's static library has, but its headers do not declare.
extern "C" {
void PaUtil_SetDebugPrintFunction(void (*print)(const char* message));
PaError PaAlsa_Initialize(void** host, PaHostApiIndex index);
PaError PaOSS_Initialize(void** host, PaHostApiIndex index);

// The sound systems that PortAudio uses, in place of its own list: without JACK, which Aula uses
// itself.
[[gnu::visibility("hidden")]] extern decltype(&PaAlsa_Initialize) paHostApiInitializers[];
decltype(&PaAlsa_Initialize) paHostApiInitializers[] = {PaAlsa_Initialize, PaOSS_Initialize,
                                                        nullptr};

// The root of ALSA's configuration: a copy of libasound's variable, which its function changes.
[[gnu::visibility("hidden")]] extern snd_config_t* snd_config;
snd_config_t* snd_config = nullptr;
[[gnu::visibility("hidden")]] int snd_config_update() {
    void* const alsa = aula::load_alsa();
    const auto update =
        reinterpret_cast<decltype(&snd_config_update)>(dlsym(alsa, "snd_config_update"));
    const int result = update();
    snd_config = *static_cast<snd_config_t**>(dlsym(alsa, "snd_config"));
    return result;
}
}

namespace aula {

namespace {

// Some servers report latencies of minutes. Longer buffers are not useful.
constexpr double kLongestLatency_s = 0.1;

// Some servers disappear without notice. A sink of PulseAudio that was idle has a buffer of two
// seconds, after which it first requests samples at the rate of the new stream.
constexpr std::chrono::milliseconds kSilenceOfLostDevice{3000};

constexpr std::chrono::seconds kLongestStart{5};

void ignore_alsa(const char*, int, const char*, int, const char*, ...) {}
void ignore_port_audio_text(const char*) {}

/// Why PortAudio refused.
std::string reason(PaError error) {
    switch (error) {
        case paDeviceUnavailable:
            return "the device is in use or not available";
        case paInvalidSampleRate:
            return "the device refuses the sample rate";
        case paInvalidChannelCount:
            return "the device has too few channels";
        case paTimedOut:
            return "the device does not answer";
        case paInsufficientMemory:
            return "there is not enough memory";
        case paUnanticipatedHostError:
            return "the sound server or driver refused";
        default:
            return "PortAudio's error " + std::to_string(error);
    }
}

/// PortAudio and the environment are not thread-safe.
std::mutex& library() {
    static std::mutex mutex;
    return mutex;
}

/// Whether ALSA's configuration is one with which PortAudio can list devices. Otherwise PortAudio
/// aborts the program: its list holds a place for every PCM of the configuration, and it asserts
/// that one remains for "default" or "dmix" when it has opened all others. Without any
/// configuration, as in a container without /usr/share/alsa, there is no place.
bool is_alsa_configured() {
    snd_config_t* pcms = nullptr;
    if (snd_config_update() < 0 || snd_config_search(snd_config, "pcm", &pcms) < 0 ||
        snd_config_get_type(pcms) != SND_CONFIG_TYPE_COMPOUND)
        return false;
    snd_config_t* last = nullptr;
    return snd_config_search(pcms, "default", &last) >= 0 ||
           snd_config_search(pcms, "dmix", &last) >= 0;
}

/// Initialises PortAudio while it exists, without messages of the libraries below.
class PortAudio {
 public:
    PortAudio() {
        const std::lock_guard lock(library());
        if (load_alsa() == nullptr)
            throw Failure("audio cannot be initialised: libasound is missing");
        snd_lib_error_set_handler(ignore_alsa);
        if (!is_alsa_configured())
            throw Failure("audio cannot be initialised: ALSA has no usable configuration");
        PaUtil_SetDebugPrintFunction(ignore_port_audio_text);
        load_silent_jack();  // a PCM of ALSA may use it
        const PaError error = Pa_Initialize();
        if (error != paNoError) {
            throw Failure("audio cannot be initialised: " + reason(error));
        }
    }
    ~PortAudio() {
        const std::lock_guard lock(library());
        Pa_Terminate();
    }
    PortAudio(const PortAudio&) = delete;
    PortAudio& operator=(const PortAudio&) = delete;

    std::vector<DeviceInfo> outputs() const {
        const std::lock_guard lock(library());
        std::vector<DeviceInfo> devices;
        for (int i = 0; i < Pa_GetDeviceCount(); ++i) {
            const PaDeviceInfo& device = *Pa_GetDeviceInfo(i);
            const PaHostApiInfo& host = *Pa_GetHostApiInfo(device.hostApi);
            if (device.maxOutputChannels <= 0) continue;
            devices.push_back({i, device.name, host.name, device.maxOutputChannels,
                               device.defaultSampleRate,
                               std::clamp(device.defaultHighOutputLatency, 0.0, kLongestLatency_s),
                               i == Pa_GetDefaultOutputDevice()});
        }
        return devices;
    }
};

/// A PortAudio stream. Callbacks run from a successful start() until destruction.
class Stream : public std::enable_shared_from_this<Stream> {
 public:
    using Call = std::function<void(const float* input, std::span<float* const> outputs,
                                    std::size_t samples, PaStreamCallbackFlags flags)>;

    explicit Stream(Call call) : call_(std::move(call)) {}

    ~Stream() {
        if (stream_ == nullptr) return;
        const std::lock_guard lock(library());
        Pa_AbortStream(stream_);
        Pa_CloseStream(stream_);
    }

    const PortAudio& port_audio() const { return port_audio_; }

    /// open(), start() and stop() require library() to be locked; the destructor locks it.
    PaError open(const PaStreamParameters* input, const PaStreamParameters* output, double rate_hz,
                 int block) {
        outputs_ = output != nullptr ? static_cast<std::size_t>(output->channelCount) : 0;
        // This starts PulseAudio's thread in this process, which receives the server's requests.
        // Without real-time priority the propagation threads would delay it.
        const RealtimePriority inherited;
        const PaError error =
            Pa_OpenStream(&stream_, input, output, rate_hz, static_cast<unsigned long>(block),
                          paNoFlag, &forward, this);
        if (error != paNoError) stream_ = nullptr;
        return error;
    }

    /// Returns paTimedOut after kLongestStart. PortAudio never returns if a server dies meanwhile:
    /// its thread ends with a lock held. The waiting thread then keeps the stream.
    PaError start() {
        std::packaged_task<PaError()> task(
            [self = shared_from_this()] { return Pa_StartStream(self->stream_); });
        std::future<PaError> result = task.get_future();
        std::thread thread(std::move(task));
        if (result.wait_for(kLongestStart) == std::future_status::timeout) {
            thread.detach();
            return paTimedOut;
        }
        thread.join();
        const PaError error = result.get();
        begun_ = error == paNoError;
        return error;
    }

    /// Stops after the buffers have been played.
    void stop() { Pa_StopStream(stream_); }

    bool active() const { return Pa_IsStreamActive(stream_) == 1; }
    const PaStreamInfo* info() const { return Pa_GetStreamInfo(stream_); }

 private:
    /// [the stream's thread, wait-free]
    static int forward(const void* input, void* output, unsigned long samples,
                       const PaStreamCallbackTimeInfo*, PaStreamCallbackFlags flags, void* self) {
        const auto& stream = *static_cast<Stream*>(self);
        const std::span outputs(static_cast<float* const*>(output), stream.outputs_);
        if (stream.begun_) {
            stream.call_(static_cast<const float*>(input), outputs, samples, flags);
        } else {
            // start() has not returned, or has timed out: `call_` may refer to a destroyed object.
            for (float* channel : outputs) std::fill_n(channel, samples, 0.0F);
        }
        return paContinue;
    }

    PortAudio port_audio_;
    Call call_;
    std::size_t outputs_ = 0;  ///< channels
    PaStream* stream_ = nullptr;
    std::atomic<bool> begun_ = false;
};

class PortAudioOutput final : public Output {
 public:
    PortAudioOutput(const DeviceInfo& device, const OutputSettings& settings)
        : device_(device),
          settings_(settings),
          stream_(std::make_shared<Stream>(
              [this](const float*, std::span<float* const> outputs, std::size_t samples,
                     PaStreamCallbackFlags flags) { fill(outputs, samples, flags); })) {
        // Indices change when devices are added or removed.
        const std::vector<DeviceInfo> devices = stream_->port_audio().outputs();
        const auto found = std::find_if(devices.begin(), devices.end(), [&](const DeviceInfo& d) {
            return d.name == device.name && d.host_api == device.host_api;
        });
        if (found == devices.end()) fail("is not available");
        const std::lock_guard lock(library());
        PaStreamParameters output{};
        output.device = found->index;
        output.channelCount = static_cast<int>(settings.channels);
        output.sampleFormat = paFloat32 | paNonInterleaved;
        output.suggestedLatency =
            std::max(device.latency_s, settings.block / settings.sample_rate_hz);
        // Otherwise ALSA's periods are two or more blocks, requested in immediate succession.
        PaAlsa_SetNumPeriods(static_cast<int>(std::ceil(output.suggestedLatency *
                                                        settings.sample_rate_hz / settings.block)) +
                             1);
        const PaError error =
            stream_->open(nullptr, &output, settings.sample_rate_hz, settings.block);
        if (error == paInvalidSampleRate) {
            refuse_rate(device, settings.sample_rate_hz, device.sample_rate_hz);
        }
        if (error != paNoError) fail("cannot be opened", error);
    }

    ~PortAudioOutput() override {
        const std::lock_guard lock(library());
        if (started_ && alive()) stream_->stop();
    }

    void start() override {
        settings_.meter->touch();
        const std::lock_guard lock(library());
        const PaError error = stream_->start();
        if (error != paNoError) fail("cannot be started", error);
        started_ = true;
    }

    bool alive() const override {
        return stream_->active() && settings_.meter->silence() < kSilenceOfLostDevice;
    }

    double latency_s() const override {
        const PaStreamInfo* const stream = stream_->info();
        const bool sane = stream != nullptr && stream->outputLatency > 0 &&
                          stream->outputLatency <= kLongestLatency_s;
        return sane ? stream->outputLatency : 0;
    }

 private:
    /// [audio thread, wait-free]
    void fill(std::span<float* const> outputs, std::size_t samples,
              PaStreamCallbackFlags flags) noexcept AULA_NONBLOCKING {
        const FlushDenormals flush;
        settings_.meter->begin((flags & paOutputUnderflow) != 0);
        settings_.call(outputs, static_cast<int>(samples));
        settings_.meter->end(static_cast<int>(samples));
    }

    [[noreturn]] void fail(const std::string& what, PaError error = paNoError) const {
        const std::string why = error == paNoError ? "" : ": " + reason(error);
        throw Failure("audio device \"" + device_.name + "\": " + what + why);
    }

    DeviceInfo device_;
    OutputSettings settings_;
    bool started_ = false;
    std::shared_ptr<Stream> stream_;  ///< destroyed before the members that it uses
};

class PortAudioInput final : public Input {
 public:
    PortAudioInput(const DeviceInfo& beside, const InputSettings& settings)
        : settings_(settings),
          stream_(std::make_shared<Stream>(
              [this](const float* input, std::span<float* const>, std::size_t samples,
                     PaStreamCallbackFlags) { record(input, samples); })) {
        const std::lock_guard lock(library());
        const int device = input_beside(beside);
        if (device == paNoDevice) throw Failure("no microphone: there is no input device");
        const PaDeviceInfo& info = *Pa_GetDeviceInfo(device);
        name_ = info.name;
        PaStreamParameters input{};
        input.device = device;
        input.channelCount = 1;
        input.sampleFormat = paFloat32;
        input.suggestedLatency = std::clamp(info.defaultLowInputLatency, 0.0, kLongestLatency_s);
        PaError error = stream_->open(&input, nullptr, settings.sample_rate_hz, settings.block);
        if (error == paNoError) error = stream_->start();
        if (error != paNoError)
            throw Failure("the microphone \"" + name_ + "\" cannot be opened: " + reason(error));
    }

    const std::string& name() const override { return name_; }
    bool alive() const override { return stream_->active(); }

 private:
    static int input_beside(const DeviceInfo& beside) {
        for (int i = 0; i < Pa_GetDeviceCount(); ++i) {
            const PaDeviceInfo& device = *Pa_GetDeviceInfo(i);
            if (device.name == beside.name && device.maxInputChannels > 0) return i;
        }
        return Pa_GetDefaultInputDevice();
    }

    /// [input thread, wait-free]
    void record(const float* input, std::size_t samples) {
        // The output thread has real-time priority, too; late input would be missing there.
        if (!std::exchange(called_, true)) take_realtime_priority();
        if (input != nullptr) settings_.callback({input, samples});
    }

    InputSettings settings_;
    std::string name_;
    bool called_ = false;             ///< [input thread]
    std::shared_ptr<Stream> stream_;  ///< destroyed before the members that it uses
};

}  // namespace

std::vector<DeviceInfo> list_port_audio_outputs() {
    // A sound system that does not answer must not hide the devices of another one.
    std::optional<PortAudio> port_audio;
    try {
        port_audio.emplace();
    } catch (const Failure&) {
        return {};
    }
    return port_audio->outputs();
}

std::unique_ptr<Output> open_port_audio_output(const DeviceInfo& device,
                                               const OutputSettings& settings) {
    return std::make_unique<PortAudioOutput>(device, settings);
}

std::unique_ptr<Input> open_port_audio_input(const DeviceInfo& beside,
                                             const InputSettings& settings) {
    return std::make_unique<PortAudioInput>(beside, settings);
}

}  // namespace aula
