#include "engine/waves/wall_damping.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "engine/waves/wall_admittance.h"

namespace aula {

namespace {

/// The squared wave number in 1/m2, of 1 Hz, that stands for that of the constant pressure: above
/// 20 Hz it changes the response by less than 0.3 %, and without it the constant pressure had a
/// pole at 0, which never decays.
constexpr double kLeastWaveNumber2 = 3.4e-4;

/// The largest amplitude, of 1 in a mode that an octave contains, of a mode outside it that counts
/// as damped by itself. The levels of octaves change by 0.1 dB at most.
constexpr double kUncoupled = 0.04;

/// Above this share of the highest frequency of the modes their amplitudes fall (kModeTaper), and
/// rays have more than nine tenths of the power, see WaveMasks.
constexpr double kHeard = 1 - kModeTaper;

/// The frequency in Hz where an octave band begins; the lowest begins at 0.
double band_begin_hz(std::size_t band) {
    return band == 0 ? 0 : double{kBandCentres_hz[band]} / std::numbers::sqrt2;
}

/// The modes that walls couple with those of an octave and the next ones on both sides of it. Its
/// limits are wave numbers in 1/m. A mode of the amplitude 1 at k excites another one by
/// D k / |k_j^2 - k^2|.
ModeRange coupled_modes(const std::vector<double>& stiffness, const DenseMatrix& damping,
                        double begin, double end) {
    const auto index_of = [&](double wave_number) {
        const auto at =
            std::lower_bound(stiffness.begin(), stiffness.end(), wave_number * wave_number);
        return static_cast<std::size_t>(at - stiffness.begin());
    };
    const ModeRange inside{std::max<std::size_t>(index_of(begin), 1) - 1,
                           std::min(index_of(end) + 1, stiffness.size())};
    const auto is_coupled = [&](std::size_t mode, double edge) {
        const double least = kUncoupled * std::abs(stiffness[mode] - edge * edge) / edge;
        for (std::size_t i = inside.first; i < inside.last; ++i)
            if (std::abs(damping.at(mode, i)) > least) return true;
        return false;
    };
    ModeRange range{0, stiffness.size()};
    while (range.first < inside.first && !is_coupled(range.first, begin)) ++range.first;
    while (range.last > inside.last && !is_coupled(range.last - 1, end)) --range.last;
    return range;
}

/// The sum over all poles, 1/m.
double decay(const std::vector<DampedPole>& poles) {
    double sum = 0;
    for (const DampedPole& pole : poles) sum -= pole.pole.real();
    return sum;
}

}  // namespace

WallDamping::WallDamping(const WaveGrid& grid, const RoomModes& modes, WorkerPool& pool)
    : modes_(modes.count()) {
    std::map<std::uint32_t, std::vector<const WaveGrid::WallPiece*>> pieces;
    for (const WaveGrid::WallPiece& piece : grid.walls) pieces[piece.material].push_back(&piece);
    const ModeColumns& shapes = modes.shapes;
    for (const auto& [material, walls] : pieces) {
        // Pressures at the walls, times the square roots of the areas.
        ModeColumns at_walls(walls.size(),
                             (modes_ + ModeColumns::kBlock - 1) / ModeColumns::kBlock);
        for (std::size_t i = 0; i < walls.size(); ++i) {
            const WaveGrid::WallPiece& wall = *walls[i];
            const float root = std::sqrt(wall.area_m2);
            for (std::size_t j = 0; j < modes_; ++j) {
                const float near = shapes.at(wall.cell, j);
                const float pressure = near + wall.beyond * (near - shapes.at(wall.inner, j));
                at_walls.at(i, j) = root * pressure;
            }
        }
        of_.emplace(material, at_walls.products(at_walls, pool));
    }
}

DenseMatrix WallDamping::damping(const RayScene& scene, std::size_t band) const {
    DenseMatrix sum(modes_, modes_);
    for (const auto& [material, matrix] : of_) {
        const double admittance =
            material == WaveGrid::kOpening
                ? 1
                : admittance_of_absorption(double{scene.material(material).absorption[band]});
        for (std::size_t i = 0; i < sum.values.size(); ++i) {
            const std::size_t row = i / modes_;
            sum.values[i] += admittance * matrix.at(row, i % modes_);
        }
    }
    return sum;
}

bool WallDamping::is_equal(const RayScene& scene, std::size_t band, std::size_t other) const {
    return std::all_of(of_.begin(), of_.end(), [&](const auto& entry) {
        if (entry.first == WaveGrid::kOpening) return true;
        const Bands& absorption = scene.material(entry.first).absorption;
        return absorption[band] == absorption[other];
    });
}

std::vector<OctavePoles> room_poles(const RoomModes& modes, const WallDamping& damping,
                                    const RayScene& scene, double speed_of_sound_m_s,
                                    WorkerPool& pool) {
    const double per_hz = 2 * std::numbers::pi / speed_of_sound_m_s;
    std::vector<double> stiffness = modes.wave_number2;
    for (double& k2 : stiffness) k2 = std::max(k2, kLeastWaveNumber2);
    // A residue contains the shape twice.
    std::vector<double> taper;
    for (const double k2 : stiffness) {
        const double below = 1 - std::sqrt(k2) / modes.highest_wave_number;
        taper.push_back(std::sqrt(std::clamp(below / kModeTaper, 0.0, 1.0)));
    }

    std::vector<OctavePoles> all;
    std::vector<std::size_t> bands;  // the first of each
    for (std::size_t band = 0; band < kBandCount; ++band) {
        const double begin = band_begin_hz(band) * per_hz;
        if (begin > modes.highest_wave_number) break;
        if (!all.empty() && damping.is_equal(scene, bands.back(), band)) continue;
        all.push_back({begin, std::numeric_limits<double>::infinity(), {}});
        bands.push_back(band);
    }
    pool.run(all.size(), [&](std::size_t i) {
        const DenseMatrix matrix = damping.damping(scene, bands[i]);
        const double end = i + 1 < all.size()
                               ? all[i + 1].begin
                               : std::max(all[i].begin, kHeard * modes.highest_wave_number);
        const ModeRange coupled = coupled_modes(stiffness, matrix, all[i].begin, end);
        all[i].poles = damped_poles(stiffness, matrix, coupled);
        for (DampedPole& pole : all[i].poles)
            for (std::size_t m = 0; m < taper.size(); ++m) pole.shape[m] *= taper[m];
    });
    // A fade lies in the octave with less damping: the other one's field is weaker.
    for (std::size_t i = 1; i < all.size(); ++i) {
        const bool is_below = decay(all[i - 1].poles) < decay(all[i].poles);
        all[i].begin *= std::exp2(is_below ? -kOctaveFade / 2 : kOctaveFade / 2);
        all[i - 1].end = all[i].begin;
    }
    return all;
}

}  // namespace aula
