#include "apps/window/view/curves.h"

#include <algorithm>
#include <cmath>

#include "apps/room/offline/acoustic_parameters.h"

namespace aula {

namespace {

constexpr double kNoiseWindow_s = 0.02;

}  // namespace

float energy_db(double energy) {
    if (!(energy > 1e-20)) return kSilence_db;
    return static_cast<float>(10 * std::log10(energy));
}

double band_energy(const Bands& bands, std::size_t band) {
    return static_cast<double>(band == kAllBands ? bands.sum() : bands[band]);
}

EnergyCurve energy_curve(const EnergyResponse& response, std::size_t band, double step_s) {
    EnergyCurve curve;
    curve.step_s = step_s;
    EnergyResponse binned = response;
    binned.paths.clear();
    for (const Bands& step : binned.uniform(step_s))
        curve.diffuse_db.push_back(energy_db(band_energy(step, band)));
    for (const SoundPath& path : response.paths)
        curve.arrivals.push_back(
            {response.arrival_s(path), energy_db(band_energy(path.energy, band)), path.order});
    return curve;
}

PairParameters view_parameters(const FrameView& view, const SpeechConditions& speech) {
    const Vec3& source = view.sources[view.source];
    return acoustic_parameters(view.response, {lateral_axis(view.listener, source), speech});
}

std::vector<float> decay_curve_db(const EnergyResponse& response, std::size_t band, double step_s) {
    const std::vector<Bands> steps = response.uniform(step_s);
    std::vector<float> decay(steps.size());
    double sum = 0;
    for (std::size_t i = steps.size(); i-- > 0;) {
        sum += band_energy(steps[i], band);
        decay[i] = energy_db(sum);
    }
    for (float& level_db : decay) level_db -= sum > 0 ? energy_db(sum) : 0;
    return decay;
}

void FrameNoise::add(const EnergyResponse& response, const Vec3& source, const Vec3& listener,
                     std::uint64_t change) {
    if (source != source_ || listener != listener_ || change != change_) {
        frames_.clear();
        next_ = 0;
        source_ = source;
        listener_ = listener;
        change_ = change;
    }
    if (frames_.size() < kFrames) frames_.emplace_back();
    frames_[next_] = response.uniform(kNoiseWindow_s);
    next_ = (next_ + 1) % kFrames;
}

std::optional<double> FrameNoise::relative(std::size_t band) const {
    if (frames_.size() < kFewest) return std::nullopt;
    const auto count = static_cast<double>(frames_.size());
    double variance_sum = 0;
    double weight_sum = 0;
    for (std::size_t window = 0; window < frames_[0].size(); ++window) {
        double sum = 0;
        double squares = 0;
        for (const auto& frame : frames_) {
            const double energy = band_energy(frame[window], band);
            sum += energy;
            squares += energy * energy;
        }
        const double mean = sum / count;
        if (!(mean > 0)) continue;
        // Relative variance, weighted by the window's energy.
        const double variance = std::max(0.0, squares / count - mean * mean) * count / (count - 1);
        variance_sum += variance / mean;
        weight_sum += mean;
    }
    if (!(weight_sum > 0)) return std::nullopt;
    return std::sqrt(variance_sum / weight_sum);
}

}  // namespace aula
