#include "aula/engine/directivity.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <complex>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <numbers>
#include <utility>

#include "aula/engine/medium.h"
#include "aula/exception.h"

namespace aula {

namespace {

constexpr double kPi = std::numbers::pi;

/// Weights of four equidistant values for a point at `share` between the second and the third: a
/// cubic polynomial with the slopes of central differences (Catmull and Rom).
std::array<float, 4> cubic_weights(float share) {
    const float t = share;
    return {0.5F * t * (-1 + t * (2 - t)), 1 + 0.5F * t * t * (3 * t - 5),
            0.5F * t * (1 + t * (4 - 3 * t)), 0.5F * t * t * (t - 1)};
}

/// The interpolation may undershoot beside a deep notch.
Bands at_least_0(Bands energy) {
    for (float& e : energy.value) e = std::max(e, 0.0F);
    return energy;
}

/// A position between table entries: the lower index, and the share of the step above it.
struct TablePlace {
    std::size_t index;
    float share;
};

TablePlace table_place(float position, std::size_t highest_index) {
    const float at = std::max(position, 0.0F);
    const std::size_t index = std::min(static_cast<std::size_t>(at), highest_index);
    return {index, std::min(at - static_cast<float>(index), 1.0F)};
}

/// Nodes and weights of the Gauss-Legendre quadrature on [0, 1], three points.
constexpr std::array<std::pair<double, double>, 3> kGauss{
    {{0.11270166537925831, 5.0 / 18}, {0.5, 8.0 / 18}, {0.88729833462074169, 5.0 / 18}}};

/// Factors that make means 1.
Bands inverse_of(const std::array<double, kBandCount>& mean) {
    Bands inverse;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        if (!(mean[b] > 0) || !std::isfinite(mean[b])) {
            throw InputError("a directivity has no energy in the octave band of " +
                             std::to_string(static_cast<int>(kBandCentres_hz[b])) +
                             " Hz; expected energy in each band");
        }
        inverse[b] = static_cast<float>(1 / mean[b]);
    }
    return inverse;
}

/// Squared pressure in the far field of a vibrating cap, on any scale.
class CapField {
 public:
    /// `size` is the wave number times the sphere's radius. Morse and Ingard, Theoretical
    /// Acoustics, section 7.2: a velocity that is 1 on the cap and else 0 has the Legendre
    /// components U_m = (P_{m-1}(cos a) - P_{m+1}(cos a)) / 2, with P_{-1} = 1, and the far field
    /// is sum_m U_m (-i)^m P_m(cos theta) / h'_m(k r).
    CapField(double size, double half_angle_rad) {
        const auto highest = static_cast<unsigned>(20 + 1.2 * size);
        const double edge = std::cos(half_angle_rad);
        const auto hankel = [&](unsigned m) {
            return std::complex(std::sph_bessel(m, size), std::sph_neumann(m, size));
        };
        std::complex<double> phase = 1;
        for (unsigned m = 0; m <= highest; ++m) {
            const double below = m == 0 ? 1 : std::legendre(m - 1, edge);
            const double velocity = 0.5 * (below - std::legendre(m + 1, edge));
            const std::complex<double> slope =
                m == 0 ? -hankel(1) : hankel(m - 1) - (m + 1) / size * hankel(m);
            components_.push_back(velocity * phase / slope);
            phase *= std::complex<double>(0, -1);
        }
    }

    double energy(double cosine) const {
        std::complex<double> pressure = 0;
        double before = 0;
        double legendre = 1;
        for (std::size_t m = 0; m < components_.size(); ++m) {
            pressure += legendre * components_[m];
            const auto n = static_cast<double>(m);
            before =
                std::exchange(legendre, ((2 * n + 1) * cosine * legendre - n * before) / (n + 1));
        }
        return std::norm(pressure);
    }

    /// The mean of energy() over all directions: that of P_m^2 is 1 / (2 m + 1).
    double mean_energy() const {
        double sum = 0;
        for (std::size_t m = 0; m < components_.size(); ++m) {
            sum += std::norm(components_[m]) / (2 * static_cast<double>(m) + 1);
        }
        return sum;
    }

 private:
    std::vector<std::complex<double>> components_;  ///< [m] factor of P_m(cos theta)
};

struct ShippedDirectivity {
    const char* name;
    Directivity (*make)();
};

/// The models of talker and loudspeaker are idealised; docs/scene_format.md describes them.
const std::array kShipped{
    ShippedDirectivity{"omni", [] { return Directivity(); }},
    ShippedDirectivity{"subcardioid", [] { return Directivity::first_order(0.7F); }},
    ShippedDirectivity{"cardioid", [] { return Directivity::first_order(0.5F); }},
    // The largest ratio of the energies to the front half and to the rear half.
    ShippedDirectivity{"supercardioid",
                       [] { return Directivity::first_order(0.5F * (std::sqrt(3.0F) - 1)); }},
    ShippedDirectivity{"figure_of_eight", [] { return Directivity::first_order(0); }},
    ShippedDirectivity{"talker",
                       [] { return Directivity::vibrating_cap(0.09F, glm::radians(10.0F)); }},
    ShippedDirectivity{"loudspeaker",
                       [] { return Directivity::vibrating_cap(0.15F, glm::radians(10.0F)); }}};

}  // namespace

/// The factor by direction.
class Directivity::Pattern {
 public:
    virtual ~Pattern() = default;
    virtual Bands factor(const Vec3& direction) const = 0;
};

class Directivity::FirstOrder final : public Pattern {
 public:
    explicit FirstOrder(float omnidirectional_share)
        : share_(omnidirectional_share),
          scale_(1 / (share_ * share_ + (1 - share_) * (1 - share_) / 3)) {}

    Bands factor(const Vec3& direction) const override {
        const float pressure = share_ + (1 - share_) * direction.x;
        return Bands::filled(scale_ * pressure * pressure);
    }

 private:
    float share_;
    float scale_;  ///< 1 over the mean of the squared pressure
};

/// A rotationally symmetric pattern as a table over the angle to the front.
class Directivity::Axial final : public Pattern {
 public:
    /// `energy`: at equal steps from 0 to pi, with the mean 1 in each band.
    explicit Axial(std::vector<Bands> energy) : energy_(std::move(energy)) {}

    Bands factor(const Vec3& direction) const override {
        const auto angle_rad = static_cast<float>(
            std::atan2(std::hypot(double{direction.y}, double{direction.z}), double{direction.x}));
        const std::size_t last = energy_.size() - 1;
        const TablePlace place =
            table_place(angle_rad * static_cast<float>(last) / std::numbers::pi_v<float>, last - 1);
        const std::array<float, 4> weights = cubic_weights(place.share);
        Bands sum;
        for (std::size_t i = 0; i < 4; ++i) {
            // Beyond 0 and pi the pattern is mirrored.
            const std::size_t at = place.index + i;  // one more than the entry's index
            const std::size_t entry = at == 0 ? 1 : at > last + 1 ? 2 * last + 1 - at : at - 1;
            sum += energy_[entry] * weights[i];
        }
        return at_least_0(sum);
    }

 private:
    std::vector<Bands> energy_;
};

class Directivity::Table final : public Pattern {
 public:
    Table(std::size_t elevations, std::size_t azimuths, std::vector<Bands> energy)
        : rows_(elevations), columns_(azimuths), energy_(std::move(energy)) {
        for (const std::size_t pole : {std::size_t{0}, rows_ - 1}) {
            const auto first = energy_.begin() + static_cast<std::ptrdiff_t>(pole * columns_);
            const auto end = first + static_cast<std::ptrdiff_t>(columns_);
            Bands mean;
            for (auto e = first; e != end; ++e) mean += *e * (1 / static_cast<float>(columns_));
            std::fill(first, end, mean);
        }
        const Bands scale = inverse_of(mean_energy());
        for (Bands& e : energy_) e *= scale;
    }

    Bands factor(const Vec3& direction) const override {
        constexpr float kTurn_rad = 2 * std::numbers::pi_v<float>;
        const glm::dvec3 to(direction);
        const float elevation_rad =
            static_cast<float>(std::atan2(to.z, std::hypot(to.x, to.y))) + kTurn_rad / 4;
        auto azimuth_rad = static_cast<float>(std::atan2(to.y, to.x));
        if (azimuth_rad < 0) azimuth_rad += kTurn_rad;
        return interpolated(
            table_place(elevation_rad / (kTurn_rad / 2) * static_cast<float>(rows_ - 1), rows_ - 2),
            table_place(azimuth_rad / kTurn_rad * static_cast<float>(columns_), columns_ - 1));
    }

 private:
    /// Beyond a pole, the rows continue on the opposite side.
    Bands interpolated(const TablePlace& row, const TablePlace& column) const {
        const std::array<float, 4> row_weights = cubic_weights(row.share);
        const std::array<float, 4> column_weights = cubic_weights(column.share);
        Bands sum;
        for (std::size_t r = 0; r < 4; ++r) {
            const std::size_t at = row.index + r;  // one more than the row's index
            const bool below = at == 0;
            const bool above = at > rows_;
            const std::size_t row_at = below ? 1 : above ? rows_ - 2 : at - 1;
            const std::size_t turned = below || above ? columns_ / 2 : 0;
            for (std::size_t c = 0; c < 4; ++c) {
                const std::size_t column_at = (column.index + c + columns_ - 1 + turned) % columns_;
                sum +=
                    energy_[row_at * columns_ + column_at] * (row_weights[r] * column_weights[c]);
            }
        }
        return at_least_0(sum);
    }

    /// The mean of the interpolated energies over all directions.
    std::array<double, kBandCount> mean_energy() const {
        const double step_rad = kPi / static_cast<double>(rows_ - 1);
        std::array<double, kBandCount> mean{};
        for (std::size_t r = 0; r + 1 < rows_; ++r) {
            for (const auto& [along_row, row_weight] : kGauss) {
                const double elevation_rad =
                    (static_cast<double>(r) + along_row) * step_rad - kPi / 2;
                const double weight = row_weight * std::cos(elevation_rad) * step_rad / 2 /
                                      static_cast<double>(columns_);
                for (std::size_t c = 0; c < columns_; ++c) {
                    for (const auto& [along_column, column_weight] : kGauss) {
                        const Bands energy = interpolated({r, static_cast<float>(along_row)},
                                                          {c, static_cast<float>(along_column)});
                        for (std::size_t b = 0; b < kBandCount; ++b)
                            mean[b] += weight * column_weight * double{energy[b]};
                    }
                }
            }
        }
        return mean;
    }

    std::size_t rows_;
    std::size_t columns_;
    std::vector<Bands> energy_;  ///< [row * columns_ + column]
};

Directivity::Directivity() = default;

Directivity::Directivity(std::shared_ptr<const Pattern> pattern) : pattern_(std::move(pattern)) {}

Directivity Directivity::first_order(float omnidirectional_share) {
    assert(omnidirectional_share >= 0 && omnidirectional_share <= 1);
    if (omnidirectional_share == 1) return {};
    return Directivity(std::make_shared<FirstOrder>(omnidirectional_share));
}

Directivity Directivity::vibrating_cap(float sphere_radius_m, float half_angle_rad) {
    constexpr std::size_t kSteps = 360;  // of half a degree from the axis
    // An octave band is the mean of the normalised patterns of so many frequencies, at equal steps
    // of the logarithm.
    constexpr int kFrequencies = 12;
    const double speed_of_sound_m_s = double{Medium{}.speed_of_sound_m_s()};
    std::vector<Bands> energy(kSteps + 1);
    for (std::size_t b = 0; b < kBandCount; ++b) {
        for (int f = 0; f < kFrequencies; ++f) {
            const double frequency_hz =
                double{kBandCentres_hz[b]} * std::exp2((f + 0.5) / kFrequencies - 0.5);
            const CapField field(
                2 * kPi * frequency_hz / speed_of_sound_m_s * double{sphere_radius_m},
                double{half_angle_rad});
            const double scale = 1 / (kFrequencies * field.mean_energy());
            for (std::size_t i = 0; i <= kSteps; ++i) {
                const double angle_rad = kPi * static_cast<double>(i) / kSteps;
                energy[i][b] += static_cast<float>(scale * field.energy(std::cos(angle_rad)));
            }
        }
    }
    return Directivity(std::make_shared<Axial>(std::move(energy)));
}

Directivity Directivity::table(std::size_t elevations, std::size_t azimuths,
                               std::vector<Bands> energy) {
    if (elevations < 3 || azimuths < 4 || azimuths % 2 != 0 ||
        energy.size() != elevations * azimuths) {
        throw InputError("a directivity of " + std::to_string(elevations) + " elevations and " +
                         std::to_string(azimuths) +
                         " azimuths; expected at least 3 elevations and an even number of at "
                         "least 4 azimuths");
    }
    for (const Bands& e : energy) {
        for (const float x : e.value) {
            if (!(x >= 0) || !std::isfinite(x))
                throw InputError("an energy of a directivity is negative or not finite");
        }
    }
    return Directivity(std::make_shared<Table>(elevations, azimuths, std::move(energy)));
}

std::optional<Directivity> Directivity::find(const std::string& name) {
    for (const ShippedDirectivity& shipped : kShipped)
        if (name == shipped.name) return shipped.make();
    return std::nullopt;
}

std::vector<std::string> Directivity::names() {
    std::vector<std::string> names;
    for (const ShippedDirectivity& shipped : kShipped) names.emplace_back(shipped.name);
    return names;
}

Bands Directivity::factor(const Vec3& direction) const {
    if (!pattern_) return Bands::filled(1);
    constexpr float kUnitLength = 1 - 1e-5F;  // with rounding
    const float length = glm::length(direction);
    if (length > kUnitLength) return pattern_->factor(direction);
    if (!(length > 0)) return Bands::filled(1);
    return Bands::filled(1 - length) + pattern_->factor(direction / length) * length;
}

Bands Directivity::on_axis_db() const {
    Bands levels_db;
    const Bands energy = factor(Vec3(1, 0, 0));
    for (std::size_t b = 0; b < kBandCount; ++b)
        levels_db[b] = static_cast<float>(10 * std::log10(double{energy[b]}));
    return levels_db;
}

}  // namespace aula
