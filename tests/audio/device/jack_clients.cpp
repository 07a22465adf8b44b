#include "tests/audio/device/jack_clients.h"

#include <jack/jack.h>

#include <algorithm>
#include <atomic>
#include <span>
#include <stdexcept>

namespace aula::test {

struct JackReceiver::State {
    jack_client_t* client = nullptr;
    jack_port_t* port = nullptr;
    std::vector<float> samples = std::vector<float>(24000);
    std::size_t count = 0;  ///< written by the server's thread
    std::atomic<bool> full = false;
    std::atomic<bool> late = false;

    static int process(jack_nframes_t frames, void* self) {
        State& s = *static_cast<State*>(self);
        const std::span<const float> sent(
            static_cast<const float*>(jack_port_get_buffer(s.port, frames)), frames);
        auto first = sent.begin();
        if (s.count == 0) first = std::find_if(first, sent.end(), [](float x) { return x != 0; });
        for (; first != sent.end() && s.count < s.samples.size(); ++first)
            s.samples[s.count++] = *first;
        s.full = s.count == s.samples.size();
        return 0;
    }
    static void set_latency(jack_latency_callback_mode_t mode, void* self) {
        if (mode != JackPlaybackLatency) return;
        jack_latency_range_t range{kMinLatency, kMaxLatency};
        jack_port_set_latency_range(static_cast<State*>(self)->port, mode, &range);
    }
    static int record_overrun(void* self) {
        static_cast<State*>(self)->late = true;
        return 0;
    }
};

JackReceiver::JackReceiver(const std::string& name) : state_(std::make_unique<State>()) {
    State& s = *state_;
    jack_status_t status{};
    s.client = jack_client_open(name.c_str(), JackNoStartServer, &status);
    if (s.client == nullptr) throw std::runtime_error("no client of the JACK server");
    s.port = jack_port_register(s.client, "in", JACK_DEFAULT_AUDIO_TYPE, JackPortIsInput, 0);
    jack_set_process_callback(s.client, &State::process, &s);
    jack_set_latency_callback(s.client, &State::set_latency, &s);
    jack_set_xrun_callback(s.client, &State::record_overrun, &s);
    jack_activate(s.client);
}

JackReceiver::~JackReceiver() { jack_client_close(state_->client); }

bool JackReceiver::full() const { return state_->full; }

const std::vector<float>& JackReceiver::samples() const { return state_->samples; }

bool JackReceiver::in_time() const { return !state_->late; }

struct JackSender::State {
    jack_client_t* client = nullptr;
    jack_port_t* port = nullptr;
    float peak = 0;

    static int process(jack_nframes_t frames, void* self) {
        const State& s = *static_cast<const State*>(self);
        auto* const samples = static_cast<float*>(jack_port_get_buffer(s.port, frames));
        for (jack_nframes_t n = 0; n < frames; ++n) {
            samples[n] = s.peak * static_cast<float>(n + 1) / static_cast<float>(frames);
        }
        return 0;
    }
};

JackSender::JackSender(float peak) : state_(std::make_unique<State>()) {
    State& s = *state_;
    s.peak = peak;
    jack_status_t status{};
    s.client = jack_client_open("player", JackNoStartServer, &status);
    if (s.client == nullptr) throw std::runtime_error("no client of the JACK server");
    s.port = jack_port_register(s.client, "out", JACK_DEFAULT_AUDIO_TYPE, JackPortIsOutput, 0);
    jack_set_process_callback(s.client, &State::process, &s);
    jack_activate(s.client);
}

JackSender::~JackSender() { jack_client_close(state_->client); }

bool JackSender::connect(const char* input) {
    return jack_connect(state_->client, jack_port_name(state_->port), input) == 0;
}

}  // namespace aula::test
