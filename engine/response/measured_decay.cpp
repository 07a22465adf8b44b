#include "engine/response/measured_decay.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

namespace aula {

namespace {

/// Bins in which sound of 50 and 80 ms is divided with an error of some 0.01 dB.
constexpr double kBin_s = 0.25e-3;

/// What precedes time zero by more is not part of the response, as the distortion products of a
/// sweep.
constexpr double kRise_s = 0.01;

double mean(std::span<const double> values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Squares a filtered response in bins from time zero on; what rings before is in the first bin.
std::vector<double> binned_energy(std::span<const double> filtered, std::size_t zero,
                                  double samples_per_bin) {
    const auto after = static_cast<double>(filtered.size() - zero);
    std::vector<double> energy(static_cast<std::size_t>(after / samples_per_bin));
    for (std::size_t n = 0; n < filtered.size(); ++n) {
        const double time = n < zero ? 0 : static_cast<double>(n - zero);
        const auto bin = static_cast<std::size_t>(time / samples_per_bin);
        if (bin < energy.size()) energy[bin] += filtered[n] * filtered[n];
    }
    return energy;
}

/// A straight decay in dB over bins.
struct Line {
    double level_db = 0;  ///< at bin 0
    double slope_db = 0;  ///< per bin, below 0

    double bin_at(double at_db) const { return (at_db - level_db) / slope_db; }
};

/// The late decay and the noise of a band, in turns until they agree.
class NoiseSearch {
 public:
    /// `resolution`: bins in which the filter resolves changes of level.
    NoiseSearch(const std::vector<double>& energy, double resolution)
        : energy_(energy), resolution_(resolution) {}

    /// The decay without noise; empty if there is none.
    std::optional<SampledDecay> decay() {
        const double count = static_cast<double>(energy_.size());
        const double latest = 0.9 * count;  // at least the last tenth is noise
        noise_ = noise_from(latest);
        std::optional<Line> line = first_line();
        if (!line) return std::nullopt;
        SampledDecay decay{.energy = energy_, .bin_s = kBin_s, .tail = {}};
        double end = 0;
        // Each turn changes the end by about a quarter of the change before. The eighth changes it
        // by less than a bin in nine of ten decays of noise, and by less than 40 ms in all.
        constexpr int kTurns = 8;
        for (int turn = 0; turn < kTurns; ++turn) {
            if (turn > 0) line = late_line(end);
            if (!line) return std::nullopt;
            // The decay meets the noise where the energy that follows is that of its power.
            tail_ = noise_ * time_constant(*line);
            end = line->bin_at(10 * std::log10(tail_));
            // A decay that lasts to the end has no known noise: what its last tenth holds is decay.
            if (!(end < latest)) return decay;
            end = std::max(end, 1.0);
            // The noise is that from 7.5 dB of decay after the end on.
            noise_ = noise_from(std::min(end - 7.5 / line->slope_db, latest));
        }
        decay.energy.resize(static_cast<std::size_t>(end));
        for (double& e : decay.energy) e -= noise_;
        decay.tail = {.energy = tail_, .time_s = time_constant(*line) * kBin_s};
        return decay;
    }

 private:
    double noise_from(double bin) const {
        return mean(std::span(energy_).subspan(static_cast<std::size_t>(bin)));
    }

    /// Bins in which the energy of a decay falls by the factor e.
    static double time_constant(const Line& line) { return -10 / (std::log(10.0) * line.slope_db); }

    /// The line of the energy that follows, from the strongest level, averaged over the resolution
    /// of the filter, to the first at most 3 dB above the noise: there the decay meets it.
    std::optional<Line> first_line() const {
        const auto width = static_cast<std::size_t>(std::max(std::ceil(resolution_), kSmoothing));
        const std::span<const double> all(energy_);
        double strongest = 0;
        double strongest_bin = 0;
        for (std::size_t bin = 0; bin + width <= energy_.size(); bin += width) {
            const double power = mean(all.subspan(bin, width));
            const auto at = static_cast<double>(bin);
            if (power > strongest) {
                strongest = power;
                strongest_bin = at;
            } else if (power <= 2 * noise_ && strongest > 4 * noise_) {
                return through(strongest, strongest_bin, at);
            }
        }
        if (!(strongest > 4 * noise_)) return std::nullopt;
        return through(strongest, strongest_bin, static_cast<double>(energy_.size()));
    }

    Line through(double strongest, double strongest_bin, double noise_bin) const {
        Line line{.slope_db = 10 * std::log10(std::max(noise_, strongest * kSilence) / strongest) /
                              (noise_bin - strongest_bin)};
        line.level_db =
            10 * std::log10(strongest * time_constant(line)) - line.slope_db * strongest_bin;
        return line;
    }

    /// The line through the last 20 dB of the backward integral to `end` that are 5 dB above what
    /// follows it; fewer where it has fewer, at least 5 dB.
    std::optional<Line> late_line(double end) const {
        const auto count = static_cast<std::size_t>(end);
        std::vector<double> rest_db(count);
        double rest = tail_;
        for (std::size_t i = count; i-- > 0;) {
            rest += energy_[i] - noise_;
            rest_db[i] = 10 * std::log10(std::max(rest, tail_ * kSilence));
        }
        if (count < 2 || !(rest > 0)) return std::nullopt;
        const double lowest_db = 10 * std::log10(tail_) + 5;
        const double highest_db = std::min(rest_db[0] - 1, lowest_db + 20);
        if (highest_db - lowest_db < 5) return std::nullopt;
        const auto last_above = [&](double level_db) {
            std::size_t i = count;
            while (i > 0 && rest_db[i - 1] < level_db) --i;
            return i;
        };
        return fitted(rest_db, last_above(highest_db), last_above(lowest_db));
    }

    static std::optional<Line> fitted(const std::vector<double>& level_db, std::size_t begin,
                                      std::size_t end) {
        if (end < begin + 3) return std::nullopt;
        const double centre = (static_cast<double>(begin) + static_cast<double>(end - 1)) / 2;
        const double mean_db = mean(std::span(level_db).subspan(begin, end - begin));
        double covariance = 0;
        double variance = 0;
        for (std::size_t i = begin; i < end; ++i) {
            const double t = static_cast<double>(i) - centre;
            covariance += t * level_db[i];
            variance += t * t;
        }
        const double slope = covariance / variance;
        if (!(slope < 0)) return std::nullopt;
        return Line{mean_db - slope * centre, slope};
    }

    static constexpr double kSmoothing = 80;   ///< bins: 20 ms
    static constexpr double kSilence = 1e-20;  ///< re what sounds

    const std::vector<double>& energy_;
    double resolution_;
    double noise_ = 0;  ///< per bin
    double tail_ = 0;
};

}  // namespace

std::size_t first_arrival(std::span<const float> response) {
    float largest = 0;
    for (const float x : response) largest = std::max(largest, std::abs(x));
    const auto first = std::find_if(response.begin(), response.end(),
                                    [&](float x) { return std::abs(x) >= largest / 10; });
    return static_cast<std::size_t>(first - response.begin());
}

std::optional<SampledDecay> measured_decay(std::span<const float> response, double sample_rate_hz,
                                           std::size_t zero, const FrequencyBand& band) {
    const std::size_t begin =
        zero - std::min(zero, static_cast<std::size_t>(kRise_s * sample_rate_hz));
    const auto ahead = static_cast<std::size_t>(band.ringing_s() * sample_rate_hz);
    std::vector<double> filtered =
        band_passed(response.subspan(begin), sample_rate_hz, band, ahead);
    // The filter averages the end of the response with the silence after it.
    const double resolution_s = 1 / band.width_hz();
    const std::size_t zero_filtered = ahead + zero - begin;
    const auto cut = static_cast<std::size_t>(resolution_s * sample_rate_hz);
    filtered.resize(std::max(zero_filtered, filtered.size() - std::min(cut, filtered.size())));
    const std::vector<double> energy =
        binned_energy(filtered, zero_filtered, kBin_s * sample_rate_hz);
    if (energy.empty()) return std::nullopt;
    return NoiseSearch(energy, resolution_s / kBin_s).decay();
}

}  // namespace aula
