#include "aula/engine/simulation.h"

#include <catch2/catch.hpp>
#include <functional>
#include <limits>
#include <string>

#include "aula/exception.h"

TEST_CASE("estimators are selected by their exact names only") {
    using aula::Estimator;
    for (const auto e :
         {Estimator::pt, Estimator::dpc_published, Estimator::dpc, Estimator::patch}) {
        CHECK(aula::estimator_from_name(aula::estimator_name(e)) == e);
    }
    CHECK(aula::estimator_name(Estimator::dpc_published) == std::string("dpc-published"));
    CHECK_FALSE(aula::estimator_from_name("dpc_published").has_value());
    CHECK_FALSE(aula::estimator_from_name("").has_value());
}

TEST_CASE("the window is the rounded number of frames in the response time, at least one") {
    aula::Simulation s;
    CHECK(s.window_frames() == 15);
    s.response_time_s = 0;
    CHECK(s.window_frames() == 1);
    s.response_time_s = 0.05F;
    CHECK(s.window_frames() == 2);
    s.response_time_s = 1;
    s.frame_rate_hz = 2.4F;
    CHECK(s.window_frames() == 2);
}

TEST_CASE("a simulation with a value out of its range is refused") {
    using aula::Simulation;
    CHECK_NOTHROW(Simulation{}.check());
    const std::function<void(Simulation&)> wrong[] = {
        [](Simulation& s) { s.rays = 0; },
        [](Simulation& s) { s.order = -1; },
        [](Simulation& s) { s.specular_order = -1; },
        [](Simulation& s) { s.specular_order = Simulation::kHighestSpecularOrder + 1; },
        [](Simulation& s) { s.diffraction_order = -1; },
        [](Simulation& s) { s.diffraction_order = Simulation::kHighestDiffractionOrder + 1; },
        [](Simulation& s) { s.patch_size_m = 0; },
        [](Simulation& s) { s.listener_radius_m = 0; },
        [](Simulation& s) { s.frame_rate_hz = 0; },
        [](Simulation& s) { s.response_time_s = -1; },
        [](Simulation& s) { s.memory_mb = 0; },
        [](Simulation& s) { s.threads = 0; },
        [](Simulation& s) { s.ir_length_s = 0.0F; },
        [](Simulation& s) { s.ir_length_s = 10.1F; },
        [](Simulation& s) { s.rays = Simulation::kMaxRays + 1; },
        [](Simulation& s) { s.order = Simulation::kMaxOrder + 1; },
        [](Simulation& s) { s.patch_size_m = 2 * Simulation::kMaxLength_m; },
        [](Simulation& s) { s.listener_radius_m = 2 * Simulation::kMaxLength_m; },
        [](Simulation& s) { s.frame_rate_hz = Simulation::kMaxFrameRate_hz + 1; },
        [](Simulation& s) { s.frame_rate_hz = std::numeric_limits<float>::quiet_NaN(); },
        [](Simulation& s) { s.response_time_s = Simulation::kMaxResponseTime_s + 1; },
        [](Simulation& s) { s.response_time_s = std::numeric_limits<float>::quiet_NaN(); },
        [](Simulation& s) { s.memory_mb = Simulation::kMaxMemory_mb + 1; },
        [](Simulation& s) { s.threads = Simulation::kMaxThreads + 1; },
    };
    for (const auto& change : wrong) {
        Simulation simulation;
        change(simulation);
        CHECK_THROWS_AS(simulation.check(), aula::InputError);
    }
    // The limits themselves are valid.
    Simulation lowest;
    lowest.rays = 1;
    lowest.order = 0;
    lowest.specular_order = 0;
    lowest.diffraction_order = 0;
    lowest.response_time_s = 0;
    lowest.memory_mb = 1;
    lowest.threads = 1;
    CHECK_NOTHROW(lowest.check());
    Simulation highest;
    highest.specular_order = Simulation::kHighestSpecularOrder;
    highest.diffraction_order = Simulation::kHighestDiffractionOrder;
    highest.ir_length_s = Simulation::kMaxIrLength_s;
    highest.rays = Simulation::kMaxRays;
    highest.order = Simulation::kMaxOrder;
    highest.patch_size_m = Simulation::kMaxLength_m;
    highest.listener_radius_m = Simulation::kMaxLength_m;
    highest.frame_rate_hz = Simulation::kMaxFrameRate_hz;
    highest.response_time_s = Simulation::kMaxResponseTime_s;
    highest.memory_mb = Simulation::kMaxMemory_mb;
    highest.threads = Simulation::kMaxThreads;
    CHECK_NOTHROW(highest.check());
}
