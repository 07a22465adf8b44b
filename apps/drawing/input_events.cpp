#include "apps/drawing/input_events.h"

#include <algorithm>

namespace aula {

void MouseEvents::add(int button, bool pressed, float x, float y) {
    if (button < 0 || button >= static_cast<int>(down_.size())) return;
    events_.push_back({static_cast<std::size_t>(button), pressed, x, y});
}

MouseEvents::Mouse MouseEvents::take() {
    if (events_.empty()) return {down_, std::nullopt};
    const Event event = events_.front();
    events_.pop_front();
    down_[event.button] = event.pressed;
    return {down_, {{event.x, event.y}}};
}

void HeldKeys::press(int key, double now_s) {
    Key& pressed = keys_[key];
    if (pressed.since_s) return;
    pressed.since_s = pressed.pressed_s = now_s;
}

void HeldKeys::release(int key, double now_s) {
    const auto released = keys_.find(key);
    if (released == keys_.end() || !released->second.since_s) return;
    Key& k = released->second;
    const double held_s = now_s - k.pressed_s;
    k.to_measure_s += now_s - *k.since_s + std::max(0.0, kTap_s - held_s);
    k.since_s.reset();
}

void HeldKeys::measure(double now_s) {
    std::erase_if(keys_, [](const auto& entry) {
        return !entry.second.since_s && entry.second.to_measure_s == 0;
    });
    for (auto& [key, k] : keys_) {
        if (k.since_s) {
            k.to_measure_s += now_s - *k.since_s;
            k.since_s = now_s;
        }
        k.measured_s = std::min(k.to_measure_s, kLongest_s);
        k.to_measure_s = 0;
    }
}

double HeldKeys::held_s(int key) const {
    const auto held = keys_.find(key);
    return held == keys_.end() ? 0 : held->second.measured_s;
}

}  // namespace aula
