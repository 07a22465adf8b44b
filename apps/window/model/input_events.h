#pragma once

#include <array>
#include <deque>
#include <map>
#include <optional>

namespace aula {

/// The mouse's buttons and place, one press or release at a time, however many there were since the
/// last picture.
class MouseEvents {
 public:
    struct Mouse {
        std::array<bool, 3> down{};  ///< left, right, middle
        /// Where a button was pressed or released; empty: the mouse is where it is.
        std::optional<std::array<float, 2>> at;
    };

    void add(int button, bool pressed, float x, float y);

    /// The mouse after the next press or release, or as it is if there is none.
    Mouse take();

    /// Presses or releases are left.
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

/// For how long keys were held, whenever that is asked.
class HeldKeys {
 public:
    void press(int key, double now_s);
    void release(int key, double now_s);

    /// A key counts as held until `now_s`; begins the next measure.
    void measure(double now_s);
    /// The seconds that a key was held in the last measure. A tap counts for kTap_s at least, and a
    /// measure for kLongest_s at most: a release is read late after a long stall.
    double held_s(int key) const;

    /// Some key is held, or has been since the last measure.
    bool any() const { return !keys_.empty(); }

    static constexpr double kTap_s = 0.08;
    static constexpr double kLongest_s = 1;

 private:
    struct Key {
        std::optional<double> since_s;  ///< of what was not measured yet; empty: not held
        double pressed_s = 0;
        double to_measure_s = 0;
        double measured_s = 0;
    };
    std::map<int, Key> keys_;
};

}  // namespace aula
