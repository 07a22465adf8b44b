#include "apps/window/model/setting_comparison.h"

#include <utility>

namespace aula {

SettingComparison::SettingComparison(const Simulation& simulation, int ambisonic_order) {
    for (Setting& setting : settings_) setting.ambisonic_order = ambisonic_order;
    restart(simulation);
}

void SettingComparison::restart(const Simulation& simulation) {
    for (Setting& setting : settings_)
        setting = {simulation, setting.ambisonic_order, false, nullptr, {}};
    active_ = 0;
    confirm();
}

void SettingComparison::set(const Simulation& simulation, int ambisonic_order) {
    settings_[active_].simulation = simulation;
    settings_[active_].ambisonic_order = ambisonic_order;
}

void SettingComparison::set_rays(int rays) {
    settings_[active_].simulation.rays = rays;
    settings_[active_].rays_given = true;
}

void SettingComparison::confirm() {
    confirmed_simulation_ = active().simulation;
    confirmed_order_ = active().ambisonic_order;
}

void SettingComparison::revert() { set(confirmed_simulation_, confirmed_order_); }

void SettingComparison::add_view(std::shared_ptr<const FrameView> view) {
    Setting& now = settings_[active_];
    if (view == now.view) return;
    if (view->source < view->sources.size())
        now.noise.add(view->response, view->sources[view->source], view->listener.position,
                      view->change);
    now.view = std::move(view);
}

void SettingComparison::discard_other_view() {
    settings_[1 - active_].view.reset();
    settings_[1 - active_].noise = {};
}

void SettingComparison::discard_views() {
    discard_other_view();
    settings_[active_].view.reset();
}

}  // namespace aula
