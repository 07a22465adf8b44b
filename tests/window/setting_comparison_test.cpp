#include "apps/window/model/setting_comparison.h"

#include <catch2/catch.hpp>

using namespace aula;

namespace {

Simulation with_rays(int rays) {
    Simulation simulation;
    simulation.rays = rays;
    return simulation;
}

/// A view of a source whose response has an energy of 1 in the first bin.
std::shared_ptr<const FrameView> view_of(std::uint64_t frame, float energy = 1) {
    auto view = std::make_shared<FrameView>();
    view->frame = frame;
    view->sources = {Vec3(1)};
    view->response.bins = TimeBins(0.1);
    view->response.energy.assign(view->response.bins.count(), Bands{});
    view->response.energy[0] = Bands::filled(energy);
    return view;
}

}  // namespace

TEST_CASE("Each of two settings keeps its values, rays and view") {
    SettingComparison settings(with_rays(100), 1);
    CHECK(settings.active_index() == 0);
    CHECK_FALSE(settings.compares());
    const auto view = view_of(1);
    settings.add_view(view);
    CHECK_FALSE(settings.compares());

    settings.switch_active();
    CHECK(settings.active_index() == 1);
    CHECK(settings.compares());
    CHECK(settings.other().view == view);
    CHECK(settings.active().view == nullptr);
    settings.set(with_rays(200), 3);
    settings.set_rays(300);
    CHECK(settings.active().simulation.rays == 300);
    CHECK(settings.active().rays_given);
    CHECK(settings.active().ambisonic_order == 3);
    CHECK(settings.other().simulation.rays == 100);
    CHECK_FALSE(settings.other().rays_given);
    CHECK(settings.other().ambisonic_order == 1);
}

TEST_CASE("A setting that cannot be played becomes the last one that played") {
    SettingComparison settings(with_rays(100), 1);
    settings.set(with_rays(200), 2);
    settings.confirm();
    settings.set(with_rays(0), 3);
    settings.revert();
    CHECK(settings.active().simulation.rays == 200);
    CHECK(settings.active().ambisonic_order == 2);
    // Before the first confirmation it is the setting of the scene.
    settings.restart(with_rays(50));
    settings.set(with_rays(0), 3);
    settings.revert();
    CHECK(settings.active().simulation.rays == 50);
}

TEST_CASE("Another scene begins with setting A, and each setting keeps its ambisonic order") {
    SettingComparison settings(with_rays(100), 1);
    settings.switch_active();
    settings.set(with_rays(200), 3);
    settings.set_rays(300);
    settings.add_view(view_of(1));
    settings.restart(with_rays(400));
    CHECK(settings.active_index() == 0);
    CHECK(settings.active().simulation.rays == 400);
    CHECK(settings.active().ambisonic_order == 1);
    CHECK(settings.other().simulation.rays == 400);
    CHECK(settings.other().ambisonic_order == 3);
    CHECK_FALSE(settings.other().rays_given);
    CHECK_FALSE(settings.compares());
}

TEST_CASE("A repeated view does not add to the noise") {
    SettingComparison settings(with_rays(100), 1);
    for (std::uint64_t frame = 0; frame < 12; ++frame)
        settings.add_view(view_of(frame, frame % 2 == 0 ? 0.9F : 1.1F));
    const auto noise = settings.active().noise.relative(kAllBands);
    REQUIRE(noise);
    CHECK(*noise == Approx(0.1).margin(0.01));
    // Of a view that is given many times only the first counts.
    const auto same = view_of(12);
    for (int i = 0; i < 100; ++i) settings.add_view(same);
    CHECK(*settings.active().noise.relative(kAllBands) > 0.09);
}

TEST_CASE("A change of the room discards the other view, a change of the sources both") {
    SettingComparison settings(with_rays(100), 1);
    const auto fill = [&] {
        for (int setting = 0; setting < 2; ++setting) {
            settings.switch_active();
            for (std::uint64_t frame = 0; frame < 10; ++frame) settings.add_view(view_of(frame));
        }
    };
    fill();
    settings.discard_other_view();
    CHECK_FALSE(settings.compares());
    CHECK_FALSE(settings.other().noise.relative(kAllBands));
    CHECK(settings.active().view);
    CHECK(settings.active().noise.relative(kAllBands));
    fill();
    settings.discard_views();
    CHECK_FALSE(settings.compares());
    CHECK_FALSE(settings.active().view);
}
