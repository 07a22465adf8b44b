#include "aula/engine/room_acoustics.h"

#include <algorithm>
#include <cmath>

#include "engine/response/decay_curve.h"
#include "engine/response/third_octave_model.h"
#include "engine/response/time_zero.h"

namespace aula {
namespace {

/// Time in s in which a diffuse field decays by 60 dB, for each band: energy falls as
/// exp(-(m + w) c t) with the losses m of the air and w = `walls_per_m` of the walls.
template <typename Walls>
Bands decay_time_s(const Bands& attenuation_per_m, double speed_of_sound_m_s,
                   const Walls& walls_per_m) {
    Bands time_s;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const double loss_per_m = double{attenuation_per_m[b]} + walls_per_m(b);
        time_s[b] = static_cast<float>(6 * std::log(10.0) / (speed_of_sound_m_s * loss_per_m));
    }
    return time_s;
}

}  // namespace

double time_zero_s(const EnergyResponse& response) {
    double first_path_s = response.bins.length_s();
    for (const SoundPath& p : response.paths) {
        const double arrival_s = response.arrival_s(p);
        if (arrival_s >= response.bins.length_s()) continue;
        if (p.order == 0) return arrival_s;
        first_path_s = std::min(first_path_s, arrival_s);
    }
    for (std::size_t i = 0; i < response.bins.count(); ++i) {
        if (first_path_s < response.bins.end_s(i)) return first_path_s;
        if (response.energy[i].max() > 0) return response.bins.begin_s(i);
    }
    return first_path_s;
}

RoomParameters room_parameters(const EnergyResponse& response) {
    const double zero_s = time_zero_s(response);
    RoomParameters result;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        result[b] = band_parameters(DecayCurve(response, zero_s, b));
    }
    return result;
}

// Eight third octaves at a time take the place of the octaves of a response.
ThirdOctaveParameters third_octave_parameters(const EnergyResponse& response,
                                              const Medium& medium) {
    const ThirdOctaveModel model(medium);
    const double zero_s = time_zero_s(response);
    ThirdOctaveParameters result;
    EnergyResponse part = response;
    for (std::size_t first = 0; first < result.size(); first += kBandCount) {
        const std::size_t count = std::min(kBandCount, result.size() - first);
        const auto take = [&](const Bands& octaves, double length_m, Bands& to) {
            const ThirdOctaveModel::Values energies = model.energies(octaves, length_m);
            std::copy_n(energies.begin() + static_cast<std::ptrdiff_t>(first), count,
                        to.value.begin());
        };
        for (std::size_t i = 0; i < response.energy.size(); ++i) {
            const double centre_s = 0.5 * (response.bins.begin_s(i) + response.bins.end_s(i));
            take(response.energy[i], centre_s * double{response.speed_of_sound_m_s},
                 part.energy[i]);
        }
        for (std::size_t p = 0; p < response.paths.size(); ++p)
            take(response.paths[p].energy, double{response.paths[p].length_m},
                 part.paths[p].energy);
        for (std::size_t b = 0; b < count; ++b)
            result[first + b] = band_parameters(DecayCurve(part, zero_s, b));
    }
    return result;
}

bool is_audible(const EnergyResponse& response) {
    const double min = std::pow(10, kAudible_g_db / 10) / kStrength_m2;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        if (response.total(b) >= min) return true;
    }
    return false;
}

Bands sabine_time_s(double mean_free_path_m, const Bands& mean_absorption,
                    const Bands& attenuation_per_m, double speed_of_sound_m_s) {
    return decay_time_s(attenuation_per_m, speed_of_sound_m_s, [&](std::size_t band) {
        return double{mean_absorption[band]} / mean_free_path_m;
    });
}

Bands eyring_time_s(double mean_free_path_m, const Bands& mean_absorption,
                    const Bands& attenuation_per_m, double speed_of_sound_m_s) {
    return decay_time_s(attenuation_per_m, speed_of_sound_m_s, [&](std::size_t band) {
        return -std::log1p(-double{mean_absorption[band]}) / mean_free_path_m;
    });
}

}  // namespace aula
