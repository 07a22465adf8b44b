#include "engine/medium.h"

#include <catch2/catch.hpp>

TEST_CASE("the speed of sound is 343.2 m/s at 20 degrees") {
    CHECK(aula::Medium{}.speed_of_sound_m_s() == Approx(343.2));
}
