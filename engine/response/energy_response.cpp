#include "aula/engine/energy_response.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace aula {

namespace {

/// Steepest decay or rise within a bin, as the logarithm of the ratio of its ends.
constexpr double kSteepest = 1;

/// The change of each band's level over bin i as the logarithm of a ratio, from the mean energies
/// per second of its neighbours; 0 beside an empty bin.
std::array<double, kBandCount> slopes(const EnergyResponse& response, std::size_t i) {
    const TimeBins& bins = response.bins;
    const std::size_t before = i > 0 ? i - 1 : i;
    const std::size_t after = std::min(i + 1, bins.count() - 1);
    const auto width_s = [&](std::size_t bin) { return bins.end_s(bin) - bins.begin_s(bin); };
    const double apart_s =
        (bins.begin_s(after) + bins.end_s(after) - bins.begin_s(before) - bins.end_s(before)) / 2;
    std::array<double, kBandCount> slope{};
    for (std::size_t b = 0; b < kBandCount && before < after; ++b) {
        const double first = double{response.energy[before][b]} / width_s(before);
        const double last = double{response.energy[after][b]} / width_s(after);
        if (!(first > 0) || !(last > 0)) continue;
        slope[b] = std::clamp(std::log(last / first) * width_s(i) / apart_s, -kSteepest, kSteepest);
    }
    return slope;
}

/// Share of an interval's energy in its part up to `x`, from 0 to 1, if the energy per time changes
/// exponentially by the factor exp(slope) over the interval.
double share_before(double x, double slope) {
    return slope == 0 ? x : std::expm1(slope * x) / std::expm1(slope);
}

}  // namespace

EnergyResponse EnergyResponse::silent(const TimeBins& bins, float speed_of_sound_m_s) {
    EnergyResponse response;
    response.bins = bins;
    response.speed_of_sound_m_s = speed_of_sound_m_s;
    response.energy.resize(bins.count());
    response.directions.resize(bins.count());
    return response;
}

void EnergyResponse::clear_bins() {
    std::fill(energy.begin(), energy.end(), Bands{});
    std::fill(directions.begin(), directions.end(), DirectionMoments{});
}

double EnergyResponse::total(std::size_t band) const {
    double sum = 0;
    for (const Bands& e : energy) sum += double{e[band]};
    for (const SoundPath& p : paths) {
        if (arrival_s(p) < bins.length_s()) sum += double{p.energy[band]};
    }
    return sum;
}

std::vector<Bands> EnergyResponse::uniform(double width_s) const {
    assert(width_s > 0);
    // Times in units of the width. Edges within rounding of an integer are set to it, so that no
    // energy leaks into a neighbour.
    const auto units = [width_s](double time_s) {
        const double x = time_s / width_s;
        const double whole = std::round(x);
        return std::abs(x - whole) < 1e-9 * std::max(1.0, whole) ? whole : x;
    };
    const auto count = static_cast<std::size_t>(std::ceil(units(bins.length_s())));
    std::vector<Bands> out(count);
    for (std::size_t i = 0; i < bins.count(); ++i) {
        const double begin = units(bins.begin_s(i));
        const double end = units(bins.end_s(i));
        const auto first = static_cast<std::size_t>(begin);
        if (end <= static_cast<double>(first) + 1) {
            out[first] += energy[i];
            continue;
        }
        const std::array<double, kBandCount> slope = slopes(*this, i);
        for (std::size_t k = first; static_cast<double>(k) < end; ++k) {
            const double low = (std::max(begin, static_cast<double>(k)) - begin) / (end - begin);
            const double high = (std::min(end, static_cast<double>(k) + 1) - begin) / (end - begin);
            for (std::size_t b = 0; b < kBandCount; ++b) {
                const double share = share_before(high, slope[b]) - share_before(low, slope[b]);
                out[k][b] += energy[i][b] * static_cast<float>(share);
            }
        }
    }
    for (const SoundPath& p : paths) {
        const double t = arrival_s(p);
        if (t < bins.length_s()) {
            out[std::min(static_cast<std::size_t>(units(t)), count - 1)] += p.energy;
        }
    }
    return out;
}

}  // namespace aula
