#include "apps/documents/value_scale.h"

#include <catch2/catch.hpp>

namespace {

using namespace aula;

using Values = std::vector<std::optional<double>>;

constexpr auto kT30 = static_cast<std::size_t>(AcousticParameter::t30);
constexpr auto kC80 = static_cast<std::size_t>(AcousticParameter::c80);

}  // namespace

TEST_CASE("A scale spans the values, and at least two just noticeable differences") {
    const ValueScale wide = value_scale(Values{-3.0, std::nullopt, 5.0}, parameter_text(kC80));
    CHECK(wide.min == Approx(-3));
    CHECK(wide.max == Approx(5));
    const ValueScale clarity = value_scale(Values{2.0}, parameter_text(kC80));
    CHECK(clarity.min == Approx(1));
    CHECK(clarity.max == Approx(3));
    const ValueScale time = value_scale(Values{2.0, 2.02}, parameter_text(kT30));
    CHECK(time.max - time.min == Approx(0.1 * 2.01));
    const ValueScale none = value_scale(Values{std::nullopt}, parameter_text(kT30));
    CHECK(none.max > none.min);
}

TEST_CASE("Round numbers lie in their range and differ in their decimals") {
    CHECK(round_numbers(0, 10, 5) == std::vector<double>{0, 2, 4, 6, 8, 10});
    CHECK(round_numbers(-1.5, 1.6, 6).front() == Approx(-1));
    for (const auto& [min, max] : {std::pair{0.713, 0.722}, {-80.0, 3.0}, {1e5, 1e5 + 1}}) {
        const std::vector<double> numbers = round_numbers(min, max, 6);
        REQUIRE(numbers.size() >= 3);
        REQUIRE(numbers.size() <= 8);
        CHECK(numbers.front() >= min - 1e-9);
        CHECK(numbers.back() <= max + 1e-9);
    }
    CHECK(round_numbers(3, 3, 6) == std::vector<double>{3});
    CHECK(decimals_of(round_numbers(0.713, 0.722, 6)) == 3);
    CHECK(decimals_of(round_numbers(0, 100, 5)) == 0);
}

TEST_CASE("Single numbers and texts are those of the parameter") {
    PairParameters parameters;
    parameters.broadband[kT30].value = 1.5;
    parameters.sti.value = 0.6;
    CHECK(single_number(parameters, kT30).value == 1.5);
    CHECK(single_number(parameters, kSpeechTransmission).value == 0.6);
    CHECK(parameter_text(kT30).symbol == "T30");
    CHECK(parameter_text(kSpeechTransmission).symbol == "STI");
}
