#include "engine/input/place_guess.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>

#include "tests/support/cpu_time.h"

using namespace aula;

TEST_CASE("Names of four languages mean sources and listeners") {
    for (const std::string name :
         {"Lautsprecher links", "LAUTSPRECHER", "Quelle.001", "Schallquelle_1", "Haut-parleur G",
          "HautParleur", "enceinte gauche", "Altavoces", "altavoz 2", "Fuente", "Main speaker",
          "Source", "Speaker at the listener"}) {
        CAPTURE(name);
        const auto guess = guess_place(name);
        REQUIRE(guess);
        CHECK_FALSE(guess->is_listener);
        CHECK_FALSE(guess->word.empty());
    }
    for (const std::string name :
         {"Zuhörer", "Zuho\xcc\x88rer", "Zuhoerer", "Hörer 3", "Empfänger", "auditeur", "Récepteur",
          "Oyente.002", "The listener at a speaker"}) {
        CAPTURE(name);
        const auto guess = guess_place(name);
        REQUIRE(guess);
        CHECK(guess->is_listener);
    }
}

TEST_CASE("Words of sources within others mean nothing") {
    for (const std::string name : {"", "Empty", "Resource", "Lichtquelle", "Gehör", "001", "\xcc"})
        CHECK_FALSE(guess_place(name));
}

TEST_CASE("The time for a name grows with its length, not with the square of it") {
    const auto time = [](int words) {
        std::string name;
        for (int i = 0; i < words; ++i) name += "a ";
        name += "haut parleur";
        return test::cpu_time_s([&] { CHECK(guess_place(name)); });
    };
    // The ratio is 8 by length and 64 by its square; the lowest of three is that without the
    // processor's other work.
    double lowest = time(32'000) / time(4'000);
    for (int i = 0; i < 2; ++i) lowest = std::min(lowest, time(32'000) / time(4'000));
    CHECK(lowest < 24);
}
