#include <jack/jack.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "audio/base/assume_nonblocking.h"
#include "audio/device/device_list.h"
#include "audio/device/output.h"
#include "audio/device/sound_libraries.h"
#include "aula/exception.h"

namespace aula {

namespace {

constexpr const char* kHostApi = "JACK";
constexpr std::size_t kMaxChannels = 16;

void ignore_jack_text(const char*) {}

struct CloseClient {
    void operator()(jack_client_t* client) const { jack_client_close(client); }
};
using Client = std::unique_ptr<jack_client_t, CloseClient>;

struct FreePorts {
    void operator()(const char** ports) const { jack_free(ports); }
};

/// Null without a server, and where JACK is not installed.
Client open_client(const char* name) {
    if (!load_silent_jack()) return nullptr;
    jack_status_t status{};
    return Client(jack_client_open(name, JackNoStartServer, &status));
}

/// Names of all input ports.
std::vector<std::string> input_ports(jack_client_t* client) {
    std::vector<std::string> inputs;
    const std::unique_ptr<const char*, FreePorts> ports(
        jack_get_ports(client, nullptr, JACK_DEFAULT_AUDIO_TYPE, JackPortIsInput));
    for (const char** port = ports.get(); port != nullptr && *port != nullptr; ++port)
        inputs.emplace_back(*port);
    return inputs;
}

class JackOutput final : public Output {
 public:
    JackOutput(const DeviceInfo& device, const OutputSettings& settings)
        : device_(device), settings_(settings), client_(open_client("aula")) {
        if (!client_) fail("the server is not available");
        const double rate_hz = jack_get_sample_rate(client_.get());
        if (rate_hz != settings.sample_rate_hz) {
            refuse_rate(device, settings.sample_rate_hz, rate_hz);
        }
        for (std::size_t c = 0; c < settings.channels; ++c) {
            const std::string name = "out_" + std::to_string(c + 1);
            ports_[c] = jack_port_register(client_.get(), name.c_str(), JACK_DEFAULT_AUDIO_TYPE,
                                           JackPortIsOutput, 0);
            if (ports_[c] == nullptr) fail("cannot register its ports");
        }
        jack_set_process_callback(client_.get(), &JackOutput::process, this);
        jack_set_xrun_callback(client_.get(), &JackOutput::count_xrun, this);
        jack_on_shutdown(client_.get(), &JackOutput::shut_down, this);
    }

    void start() override {
        settings_.meter->touch();
        if (jack_activate(client_.get()) != 0) fail("cannot be started");
        std::vector<std::string> inputs = input_ports(client_.get());
        std::erase_if(inputs,
                      [&](const std::string& port) { return client_of(port) != device_.name; });
        if (inputs.size() < settings_.channels) fail("its inputs have disappeared");
        for (std::size_t c = 0; c < settings_.channels; ++c) {
            const int error =
                jack_connect(client_.get(), jack_port_name(ports_[c]), inputs[c].c_str());
            if (error != 0 && error != EEXIST) fail("cannot be connected");
        }
        connected_ = true;
    }

    bool alive() const override { return !dead_; }

    double latency_s() const override {
        jack_latency_range_t range{};
        jack_port_get_latency_range(ports_[0], JackPlaybackLatency, &range);
        return static_cast<double>(range.max) / settings_.sample_rate_hz;
    }

 private:
    /// JACK's function is for its process callback. [audio thread]
    float* buffer(std::size_t channel, jack_nframes_t frames) noexcept AULA_NONBLOCKING {
        return static_cast<float*>(
            assume_nonblocking([&] { return jack_port_get_buffer(ports_[channel], frames); }));
    }

    /// [audio thread, wait-free]
    void fill(jack_nframes_t frames) noexcept AULA_NONBLOCKING {
        // The signal starts when all channels are connected.
        if (!connected_.load(std::memory_order_relaxed)) {
            for (std::size_t c = 0; c < settings_.channels; ++c) {
                std::fill_n(buffer(c, frames), frames, 0.0F);
            }
            seen_xruns_ = xruns_.load(std::memory_order_relaxed);
            return;
        }
        const FlushDenormals flush;
        const int xruns = xruns_.load(std::memory_order_relaxed);
        settings_.meter->begin(xruns != seen_xruns_);
        seen_xruns_ = xruns;
        std::array<float*, kMaxChannels> channels{};
        for (std::size_t c = 0; c < settings_.channels; ++c) {
            channels[c] = buffer(c, frames);
        }
        const auto samples = static_cast<int>(frames);
        settings_.call({channels.data(), settings_.channels}, samples);
        settings_.meter->end(samples);
    }

    static int process(jack_nframes_t frames, void* self) {
        static_cast<JackOutput*>(self)->fill(frames);
        return 0;
    }
    static int count_xrun(void* self) {
        static_cast<JackOutput*>(self)->xruns_.fetch_add(1, std::memory_order_relaxed);
        return 0;
    }
    static void shut_down(void* self) { static_cast<JackOutput*>(self)->dead_ = true; }

    [[noreturn]] void fail(const std::string& why) const {
        throw Failure("audio device \"" + device_.name + "\" (JACK): " + why);
    }

    DeviceInfo device_;
    OutputSettings settings_;
    std::array<jack_port_t*, kMaxChannels> ports_{};
    std::atomic<bool> dead_{false};
    std::atomic<bool> connected_{false};
    std::atomic<int> xruns_{0};
    int seen_xruns_ = 0;
    Client client_;  ///< destroyed first
};

class JackInput final : public Input {
 public:
    explicit JackInput(const InputSettings& settings)
        : settings_(settings), client_(open_client("aula-microphone")) {
        if (!client_) throw Failure("no microphone: the JACK server is not available");
        const std::unique_ptr<const char*, FreePorts> ports(
            jack_get_ports(client_.get(), nullptr, JACK_DEFAULT_AUDIO_TYPE,
                           JackPortIsOutput | JackPortIsPhysical));
        if (ports == nullptr || *ports.get() == nullptr)
            throw Failure("no microphone: the JACK server has no input");
        name_ = *ports.get();
        port_ =
            jack_port_register(client_.get(), "in", JACK_DEFAULT_AUDIO_TYPE, JackPortIsInput, 0);
        jack_set_process_callback(client_.get(), &JackInput::process, this);
        jack_on_shutdown(client_.get(), &JackInput::shut_down, this);
        if (port_ == nullptr || jack_activate(client_.get()) != 0 ||
            jack_connect(client_.get(), name_.c_str(), jack_port_name(port_)) != 0)
            throw Failure("the microphone \"" + name_ + "\" (JACK) cannot be opened");
    }

    const std::string& name() const override { return name_; }
    bool alive() const override { return !dead_; }

 private:
    /// [input thread, wait-free]
    static int process(jack_nframes_t frames, void* self) {
        auto& input = *static_cast<JackInput*>(self);
        input.settings_.callback(
            {static_cast<const float*>(jack_port_get_buffer(input.port_, frames)), frames});
        return 0;
    }
    static void shut_down(void* self) { static_cast<JackInput*>(self)->dead_ = true; }

    InputSettings settings_;
    std::string name_;
    jack_port_t* port_ = nullptr;
    std::atomic<bool> dead_{false};
    Client client_;  ///< destroyed first
};

}  // namespace

bool load_silent_jack() {
    if (load_jack() == nullptr) return false;
    jack_set_error_function(ignore_jack_text);
    jack_set_info_function(ignore_jack_text);
    return true;
}

std::vector<DeviceInfo> list_jack_outputs() {
    setenv("JACK_NO_START_SERVER", "1", 0);
    const Client client = open_client("aula-list");
    if (!client) return {};
    const double rate_hz = jack_get_sample_rate(client.get());
    std::vector<DeviceInfo> ports;
    for (const std::string& name : input_ports(client.get())) {
        jack_port_t* const port = jack_port_by_name(client.get(), name.c_str());
        DeviceInfo device;
        device.name = name;
        device.host_api = kHostApi;
        device.output_channels = 1;
        device.sample_rate_hz = rate_hz;
        jack_latency_range_t range{};
        jack_port_get_latency_range(port, JackPlaybackLatency, &range);
        device.latency_s = static_cast<double>(range.max) / rate_hz;
        device.is_default = (jack_port_flags(port) & JackPortIsPhysical) != 0;
        ports.push_back(std::move(device));
    }
    return group_by_client(ports);
}

std::unique_ptr<Output> open_jack_output(const DeviceInfo& device, const OutputSettings& settings) {
    return std::make_unique<JackOutput>(device, settings);
}

std::unique_ptr<Input> open_jack_input(const InputSettings& settings) {
    return std::make_unique<JackInput>(settings);
}

}  // namespace aula
