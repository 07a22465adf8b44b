#pragma once

#include <array>
#include <deque>
#include <map>
#include <optional>

namespace aula {

/// A queue of mouse button events. Each frame of the user interface takes one press or release, so
/// that none is lost between two frames.
class MouseEvents {
 public:
    struct Mouse {
        std::array<bool, 3> down{};  ///< left, right, middle
        /// Position of the press or release; empty without an event.
        std::optional<std::array<float, 2>> at;
    };

    void add(int button, bool pressed, float x, float y);

    /// Removes the next event and returns the buttons after it, or the present state without an
    /// event.
    Mouse take();

    /// True if events are left.
    bool pending() const { return !events_.empty(); }

 private:
    struct Event {
        std::size_t button;
        bool pressed;
        float x;
        float y;
    };
    std::deque<Event> events_;
    std::array<bool, 3> down_{};
};

/// Durations for which keys are held, independent of the frame rate. Times are in seconds.
class HeldKeys {
 public:
    void press(int key, double now_s);
    void release(int key, double now_s);

    /// Ends a measuring interval at `now_s` and begins the next.
    void measure(double now_s);
    /// Time that a key was held in the last interval. A tap counts as at least kTap_s. An interval
    /// counts as at most kLongest_s: after a stall the release event arrives late.
    double held_s(int key) const;

    /// True if a key is held or was held since the last measure().
    bool any() const { return !keys_.empty(); }

    static constexpr double kTap_s = 0.08;
    static constexpr double kLongest_s = 1;

 private:
    struct Key {
        std::optional<double> since_s;  ///< start of the unmeasured time; empty: not held
        double pressed_s = 0;
        double to_measure_s = 0;
        double measured_s = 0;
    };
    std::map<int, Key> keys_;
};

}  // namespace aula
