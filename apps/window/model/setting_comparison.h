#pragma once

#include <array>
#include <cstddef>
#include <memory>

#include "apps/room/frames/frame_view.h"
#include "apps/window/view/curves.h"
#include "aula/engine/scene.h"

namespace aula {

/// Two simulation settings of a scene, A and B, of which one is active. [one thread]
class SettingComparison {
 public:
    /// A setting, with the newest view and the noise measured while it was active.
    struct Setting {
        Simulation simulation;
        int ambisonic_order = 1;
        bool rays_given = false;  ///< by set_rays(): not reduced under overload
        std::shared_ptr<const FrameView> view;
        FrameNoise noise;
    };

    SettingComparison(const Simulation& simulation, int ambisonic_order);

    /// Begins again for another scene: both settings have `simulation`, A is active. Each keeps its
    /// ambisonic order.
    void restart(const Simulation& simulation);

    const Setting& active() const { return settings_[active_]; }
    const Setting& other() const { return settings_[1 - active_]; }
    std::size_t active_index() const { return active_; }  ///< 0: A, 1: B
    void switch_active() { active_ = 1 - active_; }

    /// Whether the other setting has a view to compare with.
    bool compares() const { return other().view != nullptr; }

    // Changes of the active setting.
    void set(const Simulation& simulation, int ambisonic_order);
    void set_rays(int rays);

    /// Records that the active setting plays.
    void confirm();
    /// Replaces the active setting by the last confirmed one, if it cannot be played.
    void revert();

    /// Adds a view of the active setting. Views of a static scene improve the noise estimate.
    void add_view(std::shared_ptr<const FrameView> view);

    /// Discards the other setting's view, to be called when the room has changed.
    void discard_other_view();
    /// Discards both views, to be called when the sources have changed.
    void discard_views();

 private:
    std::array<Setting, 2> settings_;
    std::size_t active_ = 0;
    Simulation confirmed_simulation_;
    int confirmed_order_ = 1;
};

}  // namespace aula
