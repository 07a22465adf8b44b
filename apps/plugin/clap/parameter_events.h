#pragma once

#include <clap/events.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "apps/plugin/controls.h"
#include "audio/base/assume_nonblocking.h"
#include "aula/audio/realtime.h"

namespace aula::plugin {

/// What the editor does to parameters, from the main thread to the events that the host gets from
/// the audio thread. Both ends are wait-free.
class ParameterEvents {
 public:
    struct Event {
        std::uint16_t type = CLAP_EVENT_PARAM_VALUE;  ///< or the begin or end of a gesture
        Control control{};
        double value = 0;
    };

    /// Lost if the host has taken none for a long time. [main thread]
    void push(const Event& event) noexcept {
        const std::size_t end = end_.load(std::memory_order_relaxed);
        if (end - begin_.load(std::memory_order_acquire) == kMost) return;
        events_[end % kMost] = event;
        end_.store(end + 1, std::memory_order_release);
    }

    /// Gives all to the host. [process() or flush()]
    void send(const clap_output_events_t& to) noexcept AULA_NONBLOCKING {
        const std::size_t end = end_.load(std::memory_order_acquire);
        std::size_t begin = begin_.load(std::memory_order_relaxed);
        while (begin != end && send(to, events_[begin % kMost])) ++begin;
        begin_.store(begin, std::memory_order_release);
    }

 private:
    /// Seconds of dragging with three parameters.
    static constexpr std::size_t kMost = 512;

    template <typename T>
    static clap_event_header_t header(std::uint16_t type) noexcept AULA_NONBLOCKING {
        return {.size = sizeof(T),
                .time = 0,
                .space_id = CLAP_CORE_EVENT_SPACE_ID,
                .type = type,
                .flags = 0};
    }

    static bool send(const clap_output_events_t& to, const Event& event) noexcept AULA_NONBLOCKING {
        const auto id = static_cast<clap_id>(event.control);
        if (event.type == CLAP_EVENT_PARAM_VALUE) {
            clap_event_param_value_t value{};
            value.header = header<clap_event_param_value_t>(event.type);
            value.param_id = id;
            value.note_id = value.port_index = value.channel = value.key = -1;
            value.value = event.value;
            return push_to(to, value.header);
        }
        clap_event_param_gesture_t gesture{header<clap_event_param_gesture_t>(event.type), id};
        return push_to(to, gesture.header);
    }

    /// The host's function is for process(), on the audio thread.
    static bool push_to(const clap_output_events_t& to,
                        const clap_event_header_t& header) noexcept AULA_NONBLOCKING {
        return assume_nonblocking([&] { return to.try_push(&to, &header); });
    }

    std::array<Event, kMost> events_;
    std::atomic<std::size_t> begin_ = 0;
    std::atomic<std::size_t> end_ = 0;
};

}  // namespace aula::plugin
