#include "apps/plugin/clap/clap_plugin.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <span>
#include <string>

namespace aula::plugin {

namespace {

/// A state is a few hundred bytes and two paths.
constexpr std::size_t kLongestState = 1 << 20;

/// The functions of an instance.
clap_plugin_t functions_of(ClapPlugin& plugin, const clap_plugin_descriptor_t& descriptor) {
    return {
        .desc = &descriptor,
        .plugin_data = &plugin,
        .init = [](const clap_plugin_t* self) { return ClapPlugin::of(self).init(); },
        .destroy = [](const clap_plugin_t* self) { delete &ClapPlugin::of(self); },
        .activate = [](const clap_plugin_t* self, double rate_hz, std::uint32_t,
                       std::uint32_t most) { return ClapPlugin::of(self).activate(rate_hz, most); },
        .deactivate = [](const clap_plugin_t* self) { ClapPlugin::of(self).deactivate(); },
        .start_processing = [](const clap_plugin_t*) { return true; },
        .stop_processing = [](const clap_plugin_t*) {},
        .reset = [](const clap_plugin_t* self) { ClapPlugin::of(self).reset(); },
        .process = [](const clap_plugin_t* self,
                      const clap_process_t* call) { return ClapPlugin::of(self).process(*call); },
        .get_extension = [](const clap_plugin_t*, const char* id) { return find_extension(id); },
        .on_main_thread = [](const clap_plugin_t* self) { ClapPlugin::of(self).report(); }};
}

/// Whether a call has the buffers of a port.
bool has_port(const clap_audio_buffer_t* buffers, std::uint32_t count, std::size_t channels) {
    return count >= 1 && buffers[0].channel_count >= channels && buffers[0].data32 != nullptr;
}

}  // namespace

ClapPlugin::ClapPlugin(const clap_host_t& host, const Kind& kind,
                       const clap_plugin_descriptor_t& descriptor,
                       const std::filesystem::path& folder)
    : host_(host),
      instance_(kind, folder),
      functions_(functions_of(*this, descriptor)),
      outputs_(channel_count(kind.output)) {}

bool ClapPlugin::init() {
    const auto extension = [this](const char* id) { return host_.get_extension(&host_, id); };
    threads_ = static_cast<const clap_host_thread_check_t*>(extension(CLAP_EXT_THREAD_CHECK));
    log_ = static_cast<const HostLog*>(extension(kLogExtension));
    return true;
}

bool ClapPlugin::is_main_thread() const {
    return threads_ == nullptr || threads_->is_main_thread(&host_);
}

bool ClapPlugin::activate(double sample_rate_hz, std::uint32_t longest_block) {
    if (!is_main_thread() || !instance_.activate(sample_rate_hz, longest_block)) return false;
    sample_rate_hz_ = sample_rate_hz;
    report();
    return true;
}

void ClapPlugin::deactivate() {
    if (is_main_thread()) instance_.deactivate();
}

bool ClapPlugin::save(const clap_ostream_t& stream) const {
    if (!is_main_thread()) return false;
    const std::string text = instance_.state();
    for (std::size_t done = 0; done < text.size();) {
        const std::int64_t written = stream.write(&stream, text.data() + done, text.size() - done);
        if (written <= 0) return false;
        done += static_cast<std::size_t>(written);
    }
    return true;
}

bool ClapPlugin::load(const clap_istream_t& stream) {
    if (!is_main_thread()) return false;
    std::string text;
    std::array<char, 4096> part;
    std::int64_t read = 0;
    while ((read = stream.read(&stream, part.data(), part.size())) > 0) {
        text.append(part.data(), std::min(static_cast<std::size_t>(read), part.size()));
        if (text.size() > kLongestState) return false;
    }
    return read == 0 && instance_.set_state(text);
}

void ClapPlugin::report() {
    const std::string status = instance_.new_status();
    if (!status.empty()) log(HostLog::warning, status.c_str());
}

void ClapPlugin::log(HostLog::Severity severity, const char* line) const {
    if (log_ != nullptr) log_->log(&host_, severity, line);
}

bool ClapPlugin::create_editor() {
    if (!is_main_thread()) return false;
    try {
        editor_ = std::make_unique<ClapEditor>(host_, instance_, events_);
    } catch (const std::exception& error) {
        log(HostLog::warning, error.what());
    }
    return editor_ != nullptr;
}

bool ClapPlugin::open_editor(std::uintptr_t parent) {
    if (!is_main_thread() || !editor_) return false;
    try {
        editor_->editor().open(parent);
        return true;
    } catch (const std::exception& error) {
        log(HostLog::warning, error.what());
        return false;
    }
}

void ClapPlugin::destroy_editor() {
    if (is_main_thread()) editor_.reset();
}

void ClapPlugin::apply(const clap_event_header_t& event) {
    if (event.space_id != CLAP_CORE_EVENT_SPACE_ID || event.type != CLAP_EVENT_PARAM_VALUE) return;
    const auto& change = reinterpret_cast<const clap_event_param_value_t&>(event);
    if (change.param_id < kControls)
        instance_.set_parameter(static_cast<Control>(change.param_id), change.value);
}

void ClapPlugin::flush(const clap_input_events_t* in, const clap_output_events_t* out) {
    const std::uint32_t count = in != nullptr ? in->size(in) : 0;
    for (std::uint32_t e = 0; e < count; ++e)
        if (const clap_event_header_t* const event = in->get(in, e)) apply(*event);
    if (out != nullptr) events_.send(*out);
}

/// A host without a timeline in seconds has no transport.
void ClapPlugin::begin_block(const clap_event_transport_t* transport) {
    constexpr std::uint32_t kRolls =
        CLAP_TRANSPORT_HAS_SECONDS_TIMELINE | CLAP_TRANSPORT_IS_PLAYING;
    if (transport == nullptr) return instance_.begin_block(0, false);
    const double seconds =
        static_cast<double>(transport->song_pos_seconds) / static_cast<double>(CLAP_SECTIME_FACTOR);
    instance_.begin_block(std::llround(seconds * sample_rate_hz_),
                          (transport->flags & kRolls) == kRolls);
}

clap_process_status ClapPlugin::process(const clap_process_t& call) {
    const std::size_t sources = instance_.kind().sources;
    if (!instance_.is_active() || !has_port(call.audio_inputs, call.audio_inputs_count, sources) ||
        !has_port(call.audio_outputs, call.audio_outputs_count, outputs_.size()))
        return CLAP_PROCESS_ERROR;
    std::copy_n(call.audio_outputs[0].data32, outputs_.size(), outputs_.begin());
    call.audio_outputs[0].constant_mask = 0;
    const std::span<const float* const> inputs(call.audio_inputs[0].data32, sources);
    begin_block(call.transport);
    if (call.out_events != nullptr) events_.send(*call.out_events);
    std::size_t done = 0;
    const std::uint32_t events =
        call.in_events != nullptr ? call.in_events->size(call.in_events) : 0;
    for (std::uint32_t e = 0; e < events; ++e) {
        const clap_event_header_t* const event = call.in_events->get(call.in_events, e);
        if (event == nullptr) continue;
        const std::size_t at = std::clamp<std::size_t>(event->time, done, call.frames_count);
        if (at > done) instance_.process(inputs, outputs_, done, at);
        done = at;
        apply(*event);
    }
    instance_.process(inputs, outputs_, done, call.frames_count);
    // The host's log is not for this thread.
    if (instance_.end_block()) host_.request_callback(&host_);
    return CLAP_PROCESS_CONTINUE;
}

void ClapPlugin::reset() {
    if (instance_.is_active()) instance_.restart();
}

}  // namespace aula::plugin
