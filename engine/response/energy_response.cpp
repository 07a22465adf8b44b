#include "aula/engine/energy_response.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace aula {

EnergyResponse EnergyResponse::silent(const TimeBins& bins, float speed_of_sound_m_s) {
    EnergyResponse response;
    response.bins = bins;
    response.speed_of_sound_m_s = speed_of_sound_m_s;
    response.energy.resize(bins.count());
    response.intensity.resize(bins.count());
    return response;
}

void EnergyResponse::clear_bins() {
    std::fill(energy.begin(), energy.end(), Bands{});
    std::fill(intensity.begin(), intensity.end(), Vec3(0));
}

double EnergyResponse::total(std::size_t band) const {
    double sum = 0;
    for (const Bands& e : energy) sum += double{e[band]};
    for (const SpecularPath& p : paths) {
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
        for (auto k = static_cast<std::size_t>(begin); static_cast<double>(k) < end; ++k) {
            const double low = std::max(begin, static_cast<double>(k));
            const double high = std::min(end, static_cast<double>(k) + 1);
            out[k] += energy[i] * static_cast<float>((high - low) / (end - begin));
        }
    }
    for (const SpecularPath& p : paths) {
        const double t = arrival_s(p);
        if (t < bins.length_s()) {
            out[std::min(static_cast<std::size_t>(units(t)), count - 1)] += p.energy;
        }
    }
    return out;
}

}  // namespace aula
