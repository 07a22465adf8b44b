#include "tests/plugin/clap_host.h"

#include <clap/ext/audio-ports.h>
#include <clap/ext/timer-support.h>
#if __has_include(<clap/factory/plugin-factory.h>)
#include <clap/factory/plugin-factory.h>
#else
#include <clap/plugin-factory.h>
#endif

#include <algorithm>
#include <cstring>
#include <memory>
#include <utility>

#include "tests/plugin/shared_library.h"

namespace aula::test {

namespace {

const clap_plugin_factory_t& factory() {
    static const clap_plugin_factory_t* const found = [] {
        const SharedLibrary library(AULA_CLAP_BINARY);
        const auto* const entry = library.find<const clap_plugin_entry_t*>("clap_entry");
        demand(entry != nullptr && entry->init(AULA_CLAP_BINARY), "no clap_entry");
        return static_cast<const clap_plugin_factory_t*>(
            entry->get_factory(CLAP_PLUGIN_FACTORY_ID));
    }();
    return *found;
}

ClapHost& host_of(const clap_host_t* host) { return *static_cast<ClapHost*>(host->host_data); }

/// Events of a block, of fixed memory while it is processed.
struct Events {
    std::vector<clap_event_param_value_t> changes;

    static std::uint32_t size(const clap_input_events_t* list) {
        return static_cast<std::uint32_t>(static_cast<Events*>(list->ctx)->changes.size());
    }
    static const clap_event_header_t* get(const clap_input_events_t* list, std::uint32_t index) {
        return &static_cast<Events*>(list->ctx)->changes[index].header;
    }
};

clap_event_param_value_t event_of(const ClapChange& change, std::size_t first) {
    clap_event_param_value_t event{};
    event.header = {sizeof event, static_cast<std::uint32_t>(change.sample - first),
                    CLAP_CORE_EVENT_SPACE_ID, CLAP_EVENT_PARAM_VALUE, 0};
    event.param_id = static_cast<clap_id>(change.control);
    event.note_id = event.port_index = event.channel = event.key = -1;
    event.value = change.value;
    return event;
}

std::vector<float*> pointers(Channels& channels, std::size_t first) {
    std::vector<float*> result;
    for (std::vector<float>& channel : channels) result.push_back(channel.data() + first);
    return result;
}

}  // namespace

const void* ClapHost::host_extension(const clap_host_t*, const char* id) {
    static const clap_host_thread_check_t kThreads{
        [](const clap_host_t* host) { return std::this_thread::get_id() == host_of(host).main_; },
        [](const clap_host_t* host) {
            return std::this_thread::get_id() == host_of(host).audio_.get_id();
        }};
    static const plugin::HostLog kLog{[](const clap_host_t* host, std::int32_t, const char* text) {
        ClapHost& self = host_of(host);
        // Any thread may log, but not a real-time one.
        if (std::this_thread::get_id() == self.audio_.get_id()) ++self.misuses_;
        const std::lock_guard lock(self.mutex_);
        self.logged_ += std::string(text) + "\n";
    }};
    static const clap_host_timer_support_t kTimers{
        [](const clap_host_t* host, std::uint32_t, clap_id* timer) {
            *timer = host_of(host).timer_ = 7;
            return true;
        },
        [](const clap_host_t* host, clap_id timer) {
            return std::exchange(host_of(host).timer_, CLAP_INVALID_ID) == timer;
        }};
    static const clap_host_params_t kParameters{
        [](const clap_host_t*, clap_param_rescan_flags) {},
        [](const clap_host_t*, clap_id, clap_param_clear_flags) {},
        [](const clap_host_t* host) { host_of(host).wants_flush_ = true; }};
    static const clap_host_state_t kState{
        [](const clap_host_t* host) { ++host_of(host).state_changes_; }};
    if (std::strcmp(id, CLAP_EXT_STATE) == 0) return &kState;
    if (std::strcmp(id, CLAP_EXT_TIMER_SUPPORT) == 0) return &kTimers;
    if (std::strcmp(id, CLAP_EXT_PARAMS) == 0) return &kParameters;
    if (std::strcmp(id, CLAP_EXT_THREAD_CHECK) == 0) return &kThreads;
    if (std::strcmp(id, plugin::kLogExtension) == 0) return &kLog;
    return nullptr;
}

ClapHost::ClapHost(const std::string& id)
    : host_{CLAP_VERSION,
            this,
            "tests",
            "Aula",
            "",
            "1",
            host_extension,
            [](const clap_host_t* host) { ++host_of(host).misuses_; },
            [](const clap_host_t* host) { ++host_of(host).misuses_; },
            [](const clap_host_t* host) { host_of(host).wants_callback_ = true; }} {
    plugin_ = factory().create_plugin(&factory(), &host_, id.c_str());
    demand(plugin_ != nullptr && plugin_->init(plugin_), "no instance");
    const auto& ports = extension<clap_plugin_audio_ports_t>(CLAP_EXT_AUDIO_PORTS);
    clap_audio_port_info_t info;
    demand(ports.count(plugin_, true) == 1 && ports.get(plugin_, 0, true, &info), "no input");
    inputs_ = info.channel_count;
    demand(ports.count(plugin_, false) == 1 && ports.get(plugin_, 0, false, &info), "no output");
    outputs_ = info.channel_count;
    audio_ = std::thread([this] { serve(); });
}

ClapHost::~ClapHost() {
    plugin_->destroy(plugin_);
    {
        const std::lock_guard lock(mutex_);
        ends_ = true;
    }
    changed_.notify_all();
    audio_.join();
}

void ClapHost::serve() {
    std::unique_lock lock(mutex_);
    for (;;) {
        changed_.wait(lock, [this] { return work_ || ends_; });
        if (ends_) return;
        lock.unlock();
        work_();
        lock.lock();
        work_ = nullptr;
        changed_.notify_all();
    }
}

void ClapHost::on_audio_thread(std::function<void()> work) const {
    std::unique_lock lock(mutex_);
    work_ = std::move(work);
    changed_.notify_all();
    changed_.wait(lock, [this] { return !work_; });
}

void ClapHost::set_offline(bool is_offline) {
    using Render = plugin::RenderExtension;
    demand(extension<Render>(plugin::kRenderExtension)
               .set(plugin_, is_offline ? Render::offline : Render::real_time),
           "no rendering offline");
}

bool ClapHost::activate(double rate_hz, std::uint32_t longest_block) {
    rate_hz_ = rate_hz;
    return plugin_->activate(plugin_, rate_hz, 1, longest_block);
}

double ClapHost::get(plugin::Control control) const {
    double value = -1e9;
    extension<clap_plugin_params_t>(CLAP_EXT_PARAMS)
        .get_value(plugin_, static_cast<clap_id>(control), &value);
    return value;
}

Channels ClapHost::run(const Channels& input, const std::vector<std::size_t>& sizes,
                       const std::vector<ClapChange>& changes) {
    Channels output(outputs_, std::vector<float>(input[0].size()));
    on_audio_thread([&] { plugin_->start_processing(plugin_); });
    std::size_t call = 0;
    for (std::size_t done = 0; done < input[0].size();) {
        const std::size_t samples = std::min(sizes[call++ % sizes.size()], input[0].size() - done);
        if (run_block(input, output, done, done + samples, changes) == CLAP_PROCESS_ERROR)
            return {};
        done += samples;
    }
    on_audio_thread([&] { plugin_->stop_processing(plugin_); });
    return output;
}

clap_process_status ClapHost::run_block(const Channels& input, Channels& output, std::size_t first,
                                        std::size_t last, const std::vector<ClapChange>& changes) {
    Events events;
    for (ClapChange change : next_) {
        change.sample = first;
        events.changes.push_back(event_of(change, first));
    }
    next_.clear();
    for (const ClapChange& change : changes)
        if (change.sample >= first && change.sample < last)
            events.changes.push_back(event_of(change, first));
    const clap_input_events_t in{&events, Events::size, Events::get};
    const clap_output_events_t out{this, take_edit};
    clap_event_transport_t transport{};
    transport.header = {sizeof transport, 0, CLAP_CORE_EVENT_SPACE_ID, CLAP_EVENT_TRANSPORT, 0};
    if (transport_ >= 0) {
        transport.flags = CLAP_TRANSPORT_HAS_SECONDS_TIMELINE | CLAP_TRANSPORT_IS_PLAYING;
        // Truncated, as by a host.
        transport.song_pos_seconds = static_cast<clap_sectime>(
            static_cast<double>(transport_) / rate_hz_ * static_cast<double>(CLAP_SECTIME_FACTOR));
        transport_ += static_cast<std::int64_t>(last - first);
    }
    Channels copy = input;  // the plugin must not write to it, but hosts give it as not constant
    std::vector<float*> from = pointers(copy, first);
    std::vector<float*> to = pointers(output, first);
    const clap_audio_buffer_t input_buffer{from.data(), nullptr,
                                           static_cast<std::uint32_t>(from.size()), 0, 0};
    clap_audio_buffer_t output_buffer{to.data(), nullptr, static_cast<std::uint32_t>(to.size()), 0,
                                      0};
    const clap_process_t call{-1,
                              static_cast<std::uint32_t>(last - first),
                              &transport,
                              &input_buffer,
                              &output_buffer,
                              1,
                              1,
                              &in,
                              &out};
    clap_process_status status = CLAP_PROCESS_ERROR;
    on_audio_thread([&] {
        if (violations_ == nullptr) {
            status = plugin_->process(plugin_, &call);
        } else {
            const RealtimeTrap trap;
            status = plugin_->process(plugin_, &call);
            *violations_ += trap.violations();
        }
    });
    if (copy != input) ++misuses_;
    return status;
}

bool ClapHost::take_edit(const clap_output_events_t* list, const clap_event_header_t* event) {
    std::vector<Edit>& edits = static_cast<ClapHost*>(list->ctx)->edits_;
    if (event->type == CLAP_EVENT_PARAM_VALUE) {
        const auto& change = *reinterpret_cast<const clap_event_param_value_t*>(event);
        edits.push_back({event->type, static_cast<plugin::Control>(change.param_id), change.value});
    } else {
        const auto& gesture = *reinterpret_cast<const clap_event_param_gesture_t*>(event);
        edits.push_back({event->type, static_cast<plugin::Control>(gesture.param_id), 0});
    }
    return true;
}

void ClapHost::tick() {
    if (has_timer())
        extension<clap_plugin_timer_support_t>(CLAP_EXT_TIMER_SUPPORT).on_timer(plugin_, timer_);
    if (!wants_flush_.exchange(false)) return;
    const clap_output_events_t out{this, take_edit};
    extension<clap_plugin_params_t>(CLAP_EXT_PARAMS).flush(plugin_, nullptr, &out);
}

void ClapHost::flush(plugin::Control control, double value) {
    Events events{{event_of({0, control, value}, 0)}};
    const clap_input_events_t in{&events, Events::size, Events::get};
    const clap_output_events_t out{this, take_edit};
    extension<clap_plugin_params_t>(CLAP_EXT_PARAMS).flush(plugin_, &in, &out);
}

void ClapHost::idle() {
    if (wants_callback_.exchange(false)) plugin_->on_main_thread(plugin_);
}

std::string ClapHost::save(std::size_t part) const {
    struct Stream {
        std::string bytes;
        std::size_t part;
    } stream{{}, part};
    const clap_ostream_t to{
        &stream, [](const clap_ostream_t* self, const void* bytes, std::uint64_t size) {
            auto& stored = *static_cast<Stream*>(self->ctx);
            const std::uint64_t written = std::min<std::uint64_t>(size, stored.part);
            stored.bytes.append(static_cast<const char*>(bytes), written);
            return static_cast<std::int64_t>(written);
        }};
    const bool saved = extension<clap_plugin_state_t>(CLAP_EXT_STATE).save(plugin_, &to);
    return saved ? stream.bytes : "";
}

bool ClapHost::load(const std::string& state, std::size_t part) const {
    struct Stream {
        const std::string& bytes;
        std::size_t part;
        std::size_t done = 0;
    } stream{state, part};
    const clap_istream_t from{
        &stream, [](const clap_istream_t* self, void* bytes, std::uint64_t size) {
            auto& stored = *static_cast<Stream*>(self->ctx);
            const std::size_t read = std::min(
                {static_cast<std::size_t>(size), stored.part, stored.bytes.size() - stored.done});
            std::memcpy(bytes, stored.bytes.data() + stored.done, read);
            stored.done += read;
            return static_cast<std::int64_t>(read);
        }};
    return extension<clap_plugin_state_t>(CLAP_EXT_STATE).load(plugin_, &from);
}

std::string ClapHost::logged() const {
    const std::lock_guard lock(mutex_);
    return logged_;
}

}  // namespace aula::test
