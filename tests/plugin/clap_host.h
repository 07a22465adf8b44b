#pragma once

#include <clap/entry.h>
#include <clap/events.h>
#include <clap/ext/params.h>
#include <clap/ext/state.h>
#include <clap/ext/thread-check.h>
#include <clap/plugin.h>

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "apps/plugin/clap/extensions.h"
#include "apps/plugin/controls.h"
#include "tests/plugin/channels.h"
#include "tests/support/realtime_trap.h"

namespace aula::test {

/// A change of a parameter at a sample of a signal.
struct ClapChange {
    std::size_t sample;
    plugin::Control control;
    double value;
};

/// A strict host of the built file: an instance whose main thread is the one that made it, with an
/// audio thread. Calls of the plugin on a thread that CLAP does not allow are counted.
class ClapHost {
 public:
    explicit ClapHost(const std::string& id);
    ~ClapHost();
    ClapHost(const ClapHost&) = delete;
    ClapHost& operator=(const ClapHost&) = delete;

    const clap_plugin_t& plugin() const { return *plugin_; }
    template <typename Extension>
    const Extension& extension(const char* id) const {
        return *static_cast<const Extension*>(plugin_->get_extension(plugin_, id));
    }

    void set_offline(bool is_offline);
    bool activate(double rate_hz = 48000, std::uint32_t longest_block = 8192);
    void deactivate() { plugin_->deactivate(plugin_); }

    /// The value from the next block on.
    void set(plugin::Control control, double value) { next_.push_back({0, control, value}); }
    double get(plugin::Control control) const;

    /// The transport rolls from a sample on.
    void roll(std::int64_t sample) { transport_ = sample; }

    /// Processes a signal in blocks of the given sizes, repeated, on the audio thread.
    Channels run(const Channels& input, const std::vector<std::size_t>& sizes,
                 const std::vector<ClapChange>& changes = {});

    /// Calls on_main_thread() if the plugin has asked for it.
    void idle();

    /// What the editor has told the host of parameters, in process() or flush(): events by type,
    /// each of a control, with the value of a change.
    struct Edit {
        std::uint16_t type;
        plugin::Control control;
        double value;
    };
    const std::vector<Edit>& edits() const { return edits_; }

    /// While not active: calls the timer of the editor, if it has one, and flushes parameters if it
    /// has asked for it.
    void tick();
    /// While not active: changes a parameter.
    void flush(plugin::Control control, double value);
    /// How often the plugin has marked its state as changed.
    int state_changes() const { return state_changes_; }

    bool has_timer() const { return timer_ != CLAP_INVALID_ID; }

    /// State in parts of `part` bytes; empty if it cannot be saved.
    std::string save(std::size_t part = 7) const;
    bool load(const std::string& state, std::size_t part = 7) const;

    /// Runs on the audio thread, and waits for the end.
    void on_audio_thread(std::function<void()> work) const;

    /// What process() did from now on that an audio thread must not do.
    void watch(RealtimeViolations& violations) { violations_ = &violations; }

    int misuses() const { return misuses_; }
    std::string logged() const;

 private:
    static const void* host_extension(const clap_host_t* host, const char* id);
    static bool take_edit(const clap_output_events_t* list, const clap_event_header_t* event);
    void serve();
    clap_process_status run_block(const Channels& input, Channels& output, std::size_t first,
                                  std::size_t last, const std::vector<ClapChange>& changes);

    clap_host_t host_;
    const clap_plugin_t* plugin_ = nullptr;
    std::thread::id main_ = std::this_thread::get_id();
    std::vector<ClapChange> next_;
    std::int64_t transport_ = -1;  ///< stopped
    double rate_hz_ = 48000;
    std::size_t inputs_ = 0;
    std::size_t outputs_ = 0;
    RealtimeViolations* violations_ = nullptr;
    std::atomic<int> misuses_ = 0;
    std::atomic<bool> wants_callback_ = false;
    std::atomic<bool> wants_flush_ = false;
    clap_id timer_ = CLAP_INVALID_ID;
    int state_changes_ = 0;
    std::vector<Edit> edits_;

    mutable std::mutex mutex_;  ///< of what follows
    mutable std::condition_variable changed_;
    mutable std::function<void()> work_;
    std::string logged_;
    bool ends_ = false;
    std::thread audio_;
};

}  // namespace aula::test
