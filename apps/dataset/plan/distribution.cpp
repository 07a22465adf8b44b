#include "apps/dataset/plan/distribution.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "aula/exception.h"

namespace aula {

namespace {

constexpr const char* kChoice = "a list of at least one choice";
constexpr NumberRange kShare{0, 1, true, "a number from 0 to 1"};

/// Uniform in [0, 1) with 53 bits.
double uniform(RandomStream& random) { return static_cast<double>(random.bits() >> 11U) * 0x1p-53; }

std::size_t draw_index(std::size_t count, RandomStream& random) {
    return std::min(static_cast<std::size_t>(uniform(random) * static_cast<double>(count)),
                    count - 1);
}

/// Numbers of a plan have at most 4 decimals: 0.1 mm, 0.0001 of an absorption coefficient.
double rounded_value(double x) { return std::round(x * 1e4) / 1e4; }

double read_number(const JsonReader& json, const NumberRange& range, bool whole) {
    const double number = json.number(range);
    if (whole && number != std::floor(number)) json.fail("expected a whole number");
    return number;
}

std::vector<JsonReader> read_choices(const JsonReader& json) {
    const std::vector<JsonReader> items = json.items(kChoice);
    if (items.empty()) json.fail(std::string("is empty; expected ") + kChoice);
    return items;
}

Bands draw_bands(const std::vector<NumberDistribution>& numbers, RandomStream& random) {
    if (numbers.size() == 1) return Bands::filled(static_cast<float>(numbers[0].draw(random)));
    Bands bands;
    for (std::size_t b = 0; b < kBandCount; ++b)
        bands[b] = static_cast<float>(numbers[b].draw(random));
    return bands;
}

}  // namespace

NumberDistribution::NumberDistribution(const JsonReader& json, const NumberRange& range, bool whole)
    : whole_(whole) {
    if (json.is_number()) {
        low_ = high_ = read_number(json, range, whole);
        return;
    }
    constexpr const char* kOne =
        "a number, or an object with one of uniform, log_uniform and choice";
    if (json.members(kOne).size() != 1) json.fail(std::string("expected ") + kOne);
    json.allow_keys({"uniform", "log_uniform", "choice"});
    if (const auto choice = json.find("choice")) {
        kind_ = Kind::choice;
        for (const JsonReader& item : read_choices(*choice))
            choices_.emplace_back(item, range, whole);
        return;
    }
    const auto logarithmic = json.find("log_uniform");
    const JsonReader ends = logarithmic ? *logarithmic : *json.find("uniform");
    constexpr const char* kEnds = "the lowest and the highest number";
    const std::vector<JsonReader> items = ends.items(kEnds);
    if (items.size() != 2) ends.fail(std::string("expected ") + kEnds);
    kind_ = logarithmic ? Kind::log_uniform : Kind::uniform;
    low_ = read_number(items[0], range, whole);
    high_ = read_number(items[1], range, whole);
    if (low_ > high_) ends.fail(std::string("the numbers descend; expected ") + kEnds);
    if (logarithmic && !(low_ > 0)) items[0].fail("expected a number above 0");
}

double NumberDistribution::draw(RandomStream& random) const {
    if (kind_ == Kind::choice) return choices_[draw_index(choices_.size(), random)].draw(random);
    if (low_ == high_) return low_;
    const double u = uniform(random);
    if (kind_ == Kind::log_uniform) {
        const double x = std::exp(std::lerp(std::log(low_), std::log(high_), u));
        return std::clamp(whole_ ? std::round(x) : rounded_value(x), low_, high_);
    }
    if (whole_) return std::min(low_ + std::floor(u * (high_ - low_ + 1)), high_);
    return std::clamp(rounded_value(std::lerp(low_, high_, u)), low_, high_);
}

double NumberDistribution::highest() const {
    double high = choices_.empty() ? high_ : choices_[0].highest();
    for (const NumberDistribution& choice : choices_) high = std::max(high, choice.highest());
    return high;
}

NameDistribution::NameDistribution(const JsonReader& json, const char* expected) {
    if (!json.is_object()) {
        names_.push_back(json.string(expected));
        return;
    }
    json.allow_keys({"choice"});
    for (const JsonReader& item : read_choices(json.require("choice", kChoice)))
        names_.push_back(item.string(expected));
}

const std::string& NameDistribution::draw(RandomStream& random) const {
    return names_[draw_index(names_.size(), random)];
}

std::vector<NumberDistribution> MaterialDistribution::read_bands(const JsonReader& json) {
    if (!json.is_list()) return {NumberDistribution(json, kShare)};
    std::vector<NumberDistribution> numbers;
    for (const JsonReader& item : json.items("8 numbers")) numbers.emplace_back(item, kShare);
    if (numbers.size() != kBandCount)
        json.fail("expected a number for all bands, or 8 from 63 Hz to 8 kHz");
    return numbers;
}

MaterialDistribution::MaterialDistribution(const JsonReader& json) {
    constexpr const char* kMaterial = "a material: a name, absorption and scattering, or a choice";
    if (!json.is_object()) {
        const std::string name = json.string(kMaterial);
        try {
            shipped_ = Scene().find_material(name);
        } catch (const InputError& error) {
            json.fail(error.what());
        }
        return;
    }
    if (const auto choice = json.find("choice")) {
        json.allow_keys({"choice"});
        for (const JsonReader& item : read_choices(*choice)) choices_.emplace_back(item);
        return;
    }
    json.allow_keys({"absorption", "scattering"});
    absorption_ = read_bands(json.require("absorption", kMaterial));
    const auto scattering = json.find("scattering");
    scattering_ = scattering ? read_bands(*scattering)
                             : std::vector{NumberDistribution(double{Material().scattering[0]})};
}

Material MaterialDistribution::draw(RandomStream& random) const {
    if (!choices_.empty()) return choices_[draw_index(choices_.size(), random)].draw(random);
    Material material = shipped_;
    if (shipped_.name.empty()) {
        material.absorption = draw_bands(absorption_, random);
        material.scattering = draw_bands(scattering_, random);
    }
    return material;
}

}  // namespace aula
