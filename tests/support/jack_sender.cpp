#include "tests/support/jack_sender.h"

#include <jack/jack.h>

#include <stdexcept>

namespace aula::test {

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
