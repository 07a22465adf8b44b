#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "aula/engine/scene.h"
#include "engine/base/sampling.h"
#include "engine/input/json_reader.h"

namespace aula {

/// A number of a manifest that is drawn for each scene: a constant, {"uniform": [min, max]},
/// {"log_uniform": [min, max]} or {"choice": [...]}, whose elements are such numbers.
class NumberDistribution {
 public:
    /// Always the same number.
    explicit NumberDistribution(double constant) : low_(constant), high_(constant) {}

    /// Reads a number or an object. All numbers that can be drawn are within the range, and with
    /// `whole` they are whole; both ends of a uniform distribution of whole numbers occur. Throws
    /// InputError.
    NumberDistribution(const JsonReader& json, const NumberRange& range, bool whole = false);

    double draw(RandomStream& random) const;

    /// The highest number that can be drawn.
    double highest() const;

 private:
    enum class Kind { uniform, log_uniform, choice };

    Kind kind_ = Kind::uniform;
    bool whole_ = false;
    double low_ = 0;
    double high_ = 0;
    std::vector<NumberDistribution> choices_;
};

/// A text of a manifest that is drawn for each scene: a constant or {"choice": [...]}.
class NameDistribution {
 public:
    explicit NameDistribution(std::string constant) : names_{std::move(constant)} {}
    /// Throws InputError; `expected` describes a text.
    NameDistribution(const JsonReader& json, const char* expected);

    const std::string& draw(RandomStream& random) const;

    const std::vector<std::string>& names() const { return names_; }

 private:
    std::vector<std::string> names_;
};

/// A material of a manifest that is drawn for each scene: the name of a material that ships,
/// {"absorption": .., "scattering": ..} with a number or 8 numbers each, or {"choice": [...]}.
class MaterialDistribution {
 public:
    /// Throws InputError.
    explicit MaterialDistribution(const JsonReader& json);

    /// A material, with its name if it ships.
    Material draw(RandomStream& random) const;

 private:
    /// One number for all bands, or 8.
    static std::vector<NumberDistribution> read_bands(const JsonReader& json);

    std::vector<MaterialDistribution> choices_;
    Material shipped_;                            ///< if it has a name
    std::vector<NumberDistribution> absorption_;  ///< if there are no choices and no name
    std::vector<NumberDistribution> scattering_;
};

}  // namespace aula
