#include "engine/scene/directivity_measurements.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <optional>
#include <utility>

#include "aula/exception.h"
#include "engine/scene/embedded_directivity_reader.h"
#include "process/contained_process.h"

namespace aula {

namespace {

constexpr std::size_t kRows = 37;  // steps of 5 degrees
constexpr std::size_t kColumns = 72;

/// Measured directions that a direction is interpolated from: those around a cell of a grid.
constexpr std::size_t kNeighbours = 8;

/// Unit vectors at a smaller distance are one direction.
constexpr double kSame = 1e-3;

/// Energies in the octave bands at unit distance.
std::vector<Bands> band_energies(const DirectivityMeasurements& measurements) {
    const std::vector<double>& frequencies_hz = measurements.frequencies_hz;
    std::array<std::vector<std::size_t>, kBandCount> members;
    for (std::size_t f = 0; f < frequencies_hz.size(); ++f) {
        for (std::size_t b = 0; b < kBandCount; ++b) {
            const double ratio = frequencies_hz[f] / double{kBandCentres_hz[b]};
            if (ratio >= std::numbers::sqrt2 / 2 && ratio < std::numbers::sqrt2)
                members[b].push_back(f);
        }
    }
    const auto measured = members;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        for (std::size_t away = 1; members[b].empty() && away < kBandCount; ++away) {
            if (b >= away) members[b] = measured[b - away];
            if (members[b].empty() && b + away < kBandCount) members[b] = measured[b + away];
        }
    }
    if (members[0].empty())
        throw InputError("no frequency is in an octave band; expected some from 45 Hz to 11 kHz");
    std::vector<Bands> energies;
    for (std::size_t d = 0; d < measurements.positions.size(); ++d) {
        const auto& [x, y, z] = measurements.positions[d];
        const double distance_2 = x * x + y * y + z * z;
        energies.emplace_back();
        for (std::size_t b = 0; b < kBandCount; ++b) {
            double sum = 0;
            for (const std::size_t f : members[b])
                sum += measurements.energies[d * frequencies_hz.size() + f];
            energies.back()[b] =
                static_cast<float>(sum / static_cast<double>(members[b].size()) * distance_2);
        }
    }
    return energies;
}

/// A direction with its mean energies.
struct Sample {
    glm::dvec3 direction{0};
    Bands energy;
};

/// One sample for each direction: grids repeat the poles.
std::vector<Sample> distinct(const std::vector<Sample>& measured) {
    std::vector<Sample> samples;
    std::vector<float> counts;
    for (const Sample& m : measured) {
        std::size_t i = 0;
        while (i < samples.size() && glm::distance(samples[i].direction, m.direction) >= kSame) ++i;
        if (i == samples.size()) {
            samples.push_back({m.direction, {}});
            counts.push_back(0);
        }
        samples[i].energy += m.energy;
        ++counts[i];
    }
    for (std::size_t i = 0; i < samples.size(); ++i) samples[i].energy *= 1 / counts[i];
    return samples;
}

/// The mean of the nearest samples, with weights that are continuous in the direction: they become
/// 0 at the distance of the next sample [Franke, Nielson 1980].
Bands interpolated(const glm::dvec3& direction, const std::vector<Sample>& samples) {
    std::vector<std::pair<double, std::size_t>> nearest;  // distance and index
    for (std::size_t i = 0; i < samples.size(); ++i)
        nearest.emplace_back(glm::distance(direction, samples[i].direction), i);
    const std::size_t count = std::min(kNeighbours + 1, nearest.size());
    std::partial_sort(nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(count),
                      nearest.end());
    if (nearest[0].first < kSame) return samples[nearest[0].second].energy;
    constexpr double kBeyondAll = 2.1;  // of unit vectors, which are up to 2 apart
    const double reach = count > kNeighbours ? nearest[kNeighbours].first : kBeyondAll;
    Bands sum;
    double weights = 0;
    for (std::size_t k = 0; k < count; ++k) {
        const auto [distance, i] = nearest[k];
        const double weight = std::pow((reach - distance) / (reach * distance), 2);
        sum += samples[i].energy * static_cast<float>(weight);
        weights += weight;
    }
    if (!(weights > 0)) return samples[nearest[0].second].energy;
    return sum * static_cast<float>(1 / weights);
}

glm::dvec3 from_spherical(double azimuth_deg, double elevation_deg) {
    const double azimuth_rad = glm::radians(azimuth_deg);
    const double elevation_rad = glm::radians(elevation_deg);
    return {std::cos(azimuth_rad) * std::cos(elevation_rad),
            std::sin(azimuth_rad) * std::cos(elevation_rad), std::sin(elevation_rad)};
}

bool all_finite(const std::vector<double>& values) {
    return std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); });
}

/// Positions in the axes of the source.
std::vector<std::array<double, 3>> local_positions(const DirectivityHeader& header,
                                                   const std::vector<double>& coordinates) {
    const auto vector = [](const std::array<double, 3>& v) { return glm::dvec3(v[0], v[1], v[2]); };
    const glm::dvec3 front = glm::normalize(vector(header.view));
    const glm::dvec3 left = glm::normalize(glm::cross(vector(header.up), front));
    const glm::dvec3 up = glm::cross(front, left);
    if (!std::isfinite(left.x + left.y + left.z + up.x))
        throw InputError("the axes of its source are not two directions");
    std::vector<std::array<double, 3>> positions;
    for (std::size_t i = 0; i + 2 < coordinates.size(); i += 3) {
        const glm::dvec3 p =
            header.spherical != 0
                ? coordinates[i + 2] * from_spherical(coordinates[i], coordinates[i + 1])
                : glm::dvec3(coordinates[i], coordinates[i + 1], coordinates[i + 2]);
        positions.push_back({glm::dot(p, front), glm::dot(p, left), glm::dot(p, up)});
    }
    return positions;
}

}  // namespace

Directivity directivity_of(const DirectivityMeasurements& measurements) {
    if (!all_finite(measurements.frequencies_hz) || !all_finite(measurements.energies))
        throw InputError("a value is not finite");
    std::vector<Sample> measured;
    for (const auto& [x, y, z] : measurements.positions) {
        const double distance_m = std::hypot(x, y, z);
        if (!(distance_m > 1e-6 && distance_m < 1e6))
            throw InputError("a direction is not one; expected positions away from the source");
        measured.push_back({glm::dvec3(x, y, z) / distance_m, {}});
    }
    const std::vector<Bands> energies = band_energies(measurements);
    for (std::size_t d = 0; d < measured.size(); ++d) measured[d].energy = energies[d];
    const std::vector<Sample> samples = distinct(measured);
    std::vector<Bands> table;
    for (std::size_t r = 0; r < kRows; ++r) {
        for (std::size_t c = 0; c < kColumns; ++c) {
            const glm::dvec3 direction =
                from_spherical(5 * static_cast<double>(c), 5 * static_cast<double>(r) - 90);
            table.push_back(interpolated(direction, samples));
        }
    }
    return Directivity::table(kRows, kColumns, std::move(table));
}

Directivity directivity_of(const DirectivityAnswer& answer) {
    return directivity_of({local_positions(answer.header, answer.coordinates),
                           answer.frequencies_hz, answer.energies});
}

namespace {

ContainedProgram directivity_reader(const std::filesystem::path& file) {
    try {
        return embedded_directivity_reader();
    } catch (const InputError& error) {
        throw InputError(file.string() + ": " + error.what());
    }
}

}  // namespace

Directivity read_sofa_directivity(const std::filesystem::path& file) {
    constexpr const char* kDamaged = "is damaged and cannot be read as SOFA";
    ContainedProcess reader(directivity_reader(file), file,
                            "a SOFA file of a source's directivity (FreeFieldDirectivityTF)");
    using Verdict = DirectivityHeader::Verdict;
    DirectivityAnswer answer;
    DirectivityHeader& header = answer.header;
    reader.read(header);
    if (header.magic != DirectivityHeader::kMagic) reader.refuse(kDamaged);
    switch (header.verdict) {
        case Verdict::usable:
            break;
        case Verdict::other_kind:
            reader.refuse("is a SOFA file of another kind");
            break;
        case Verdict::incomplete:
            reader.refuse(
                "has not the variables Data.Real, Data.Imag, N and ReceiverPosition in sizes that "
                "fit");
            break;
        case Verdict::too_large:
            reader.refuse(
                "has more than 16384 directions or frequencies, or more than 16777216 values");
            break;
        default:
            reader.refuse("cannot be read as SOFA");
    }
    if (header.directions == 0 || header.directions > DirectivityHeader::kMaxDirections ||
        header.frequencies == 0 || header.frequencies > DirectivityHeader::kMaxFrequencies)
        reader.refuse(kDamaged);
    answer.coordinates.resize(std::size_t{3} * header.directions);
    answer.frequencies_hz.resize(header.frequencies);
    answer.energies.resize(std::size_t{header.directions} * header.frequencies);
    reader.read(answer.coordinates);
    reader.read(answer.frequencies_hz);
    reader.read(answer.energies);
    try {
        return directivity_of(answer);
    } catch (const InputError& error) {
        throw InputError(file.string() + ": " + error.what());
    }
}

}  // namespace aula
