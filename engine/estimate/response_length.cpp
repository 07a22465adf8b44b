#include "engine/estimate/response_length.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>
#include <vector>

#include "engine/base/air_attenuation.h"
#include "engine/rays/room_survey.h"
#include "engine/trace/sound_particles.h"

namespace aula {

namespace {

/// A response should be 60 dB down at its end. 3 dB are three standard errors of this estimate, and
/// 7 dB those of a response of a few frames, whose late bins are the purely specular paths of a few
/// rays (`test_cases "In random rooms*"`).
constexpr double kDecay_db = 70;

/// A choice: a response of the direct sound alone has the bins of clarity and definition, 80 ms,
/// and room for sources and listeners that come later.
constexpr double kShortest_s = 0.3;

/// For the direct sound in the open: filters and diffraction after its arrival.
constexpr double kAfterDirect_s = 0.1;

/// Time between two observations; the shortest reverberation times are several times longer.
constexpr double kStep_s = 0.008;

/// Positions that represent all. A choice: each of eight still has half of kParticles.
constexpr std::size_t kMaxPlaces = 8;

/// Particles of one source position and of all together. The level after this decay then has
/// a standard error of about 1 dB.
constexpr std::size_t kParticles = 1024;
constexpr std::size_t kAllParticles = 4096;  // of four positions

/// Particles within this number of mean free paths are near a listener: the energy density of a
/// room varies little over one.
constexpr float kNear_free_paths = 2;

/// After both, particles have been reflected a few times, and the slope is that of the room.
/// Choices: about a quarter of the reverberation time of a usual room, and four mean free paths.
constexpr double kSlope_s = 0.25;
constexpr float kSlope_free_paths = 4;  // about as many reflections

/// At most kMaxPlaces of the positions that are far from each other: each next one is the farthest
/// from those before.
std::vector<Vec3> far_apart(std::span<const Vec3> positions) {
    std::vector<Vec3> chosen;
    std::vector<float> nearest_m(positions.size(), std::numeric_limits<float>::infinity());
    while (!positions.empty() && chosen.size() < kMaxPlaces) {
        const auto next = std::max_element(nearest_m.begin(), nearest_m.end());
        if (!(*next > 0)) break;
        chosen.push_back(positions[static_cast<std::size_t>(next - nearest_m.begin())]);
        for (std::size_t i = 0; i < positions.size(); ++i)
            nearest_m[i] = std::min(nearest_m[i], glm::distance(positions[i], chosen.back()));
    }
    return chosen;
}

/// A decay by kDecay_db.
struct Decay {
    double length_s = 0;
    bool observed = true;  ///< false: the length by the present slope

    void take(const Decay& other) {
        length_s = std::max(length_s, other.length_s);
        observed = observed && other.observed;
    }
};

/// Energies at equal times, band by band.
class DecayHistory {
 public:
    void add(const std::array<double, kBandCount>& energy) { energies_.push_back(energy); }

    /// The longest decay of all bands. Energies of a room are sums of exponentials: a slope becomes
    /// less steep, so that a length by the present slope is the least possible.
    Decay decay() const {
        Decay longest;
        for (std::size_t b = 0; b < kBandCount; ++b) longest.take(decay(b));
        return longest;
    }

 private:
    Decay decay(std::size_t band) const {
        const std::size_t count = energies_.size();
        const auto sum = [&](std::size_t from, std::size_t to) {
            double energy = 0;
            for (std::size_t i = from; i < to; ++i) energy += energies_[i][band];
            return energy;
        };
        // The energies of the last two quarters give the late slope: with their ratio r the
        // quarters that follow have e2 r + e2 r^2 + .. = e2 r / (1 - r). A slower decay than by
        // 0.04 dB per quarter, 10 lg(kSlowest), cannot be distinguished from none.
        constexpr double kSlowest = 0.99;
        const std::size_t quarter = count / 4;
        const double e1 = sum(count - 2 * quarter, count - quarter);
        const double e2 = sum(count - quarter, count);
        const double r = e2 < kSlowest * e1 ? e2 / e1 : e2 > 0 ? kSlowest : 0.0;
        const double tail = e2 * r / (1 - r);
        const double limit = std::pow(10, -kDecay_db / 10) * (sum(0, count) + tail);
        if (tail > limit) {
            const double quarter_s = kStep_s * static_cast<double>(quarter);
            return {kStep_s * static_cast<double>(count) +
                        quarter_s * std::log(limit / tail) / std::log(r),
                    false};
        }
        double after = tail;
        std::size_t length = count;
        while (length > 0 && after + energies_[length - 1][band] <= limit)
            after += energies_[--length][band];
        return {kStep_s * static_cast<double>(length), true};
    }

    std::vector<std::array<double, kBandCount>> energies_;
};

/// Follows the sound from one position until it has decayed at the listeners.
class DecayObservation {
 public:
    DecayObservation(const RayScene& scene, const Medium& medium, std::span<const Vec3> listeners,
                     float free_path_m, SoundParticles particles, WorkerPool& workers)
        : scene_(scene),
          attenuation_per_m_(medium.attenuation_per_m()),
          step_m_(static_cast<float>(kStep_s) * medium.speed_of_sound_m_s()),
          listeners_(listeners),
          near_m_(kNear_free_paths * free_path_m),
          slope_m_(kSlope_free_paths * free_path_m),
          workers_(workers),
          particles_(std::move(particles)),
          near_(listeners.size(), std::vector<float>(particles_.all().size())),
          at_(listeners.size()) {}

    /// The length of the longest decay of the listeners' energies and of the whole energy. What
    /// reaches a listener through a small opening may be one particle, whose descendants decay as
    /// its room; the whole energy shows what else the source's room still has to give.
    double length_s(double longest_s) {
        // Observations before the first evaluation, of which a quarter gives the late slope, and
        // the growth of the time between two evaluations. Choices: 0.13 s, and a response is
        // followed for up to 15 % longer than it needs.
        constexpr std::size_t kFirst = 16;
        constexpr double kGrowth = 1.15;
        const auto most = static_cast<std::size_t>(std::ceil(longest_s / kStep_s));
        std::size_t next = kFirst;
        for (std::size_t step = 1; step < most; ++step) {
            observe();
            particles_.advance(step_m_, workers_);
            if (step < next) continue;
            next = static_cast<std::size_t>(std::ceil(kGrowth * static_cast<double>(step)));
            const Decay present = decay();
            if (present.observed) return present.length_s;
            // The energy at a listener may still rise; the whole energy cannot.
            if (kStep_s * static_cast<double>(step) > kSlope_s && travelled_m_ > slope_m_ &&
                whole_.decay().length_s > longest_s)
                return longest_s;
        }
        return std::min(decay().length_s, longest_s);
    }

 private:
    Decay decay() const {
        Decay longest = whole_.decay();
        for (const DecayHistory& history : at_) longest.take(history.decay());
        return longest;
    }

    /// Adds the present energies to the histories, and renews the population: one half of it in
    /// proportion to all energy, one half to that near the listeners, band by band, so that neither
    /// a band nor a listener is left without particles.
    void observe() {
        find_near();
        const std::span<const SoundParticle> all = particles_.all();
        const Bands air = transmission(attenuation_per_m_, travelled_m_);
        travelled_m_ += step_m_;
        std::vector<double> importance(all.size());
        const auto add = [&](DecayHistory& history, const auto& weight) {
            std::array<double, kBandCount> energy{};
            for (std::size_t i = 0; i < all.size(); ++i)
                for (std::size_t b = 0; b < kBandCount && weight(i) > 0; ++b)
                    energy[b] += weight(i) * double{all[i].energy[b]};
            for (std::size_t i = 0; i < all.size(); ++i)
                for (std::size_t b = 0; b < kBandCount && weight(i) > 0; ++b)
                    if (energy[b] > 0)
                        importance[i] +=
                            weight(i) * double{all[i].energy[b]} / energy[b] * share_of(history);
            for (std::size_t b = 0; b < kBandCount; ++b) energy[b] *= double{air[b]};
            history.add(energy);
        };
        add(whole_, [](std::size_t) { return 1.0; });
        for (std::size_t l = 0; l < listeners_.size(); ++l)
            add(at_[l], [&](std::size_t i) { return double{near_[l][i]}; });
        particles_.choose(importance);
    }

    /// The share of the population for a history.
    double share_of(const DecayHistory& history) const {
        return &history == &whole_ ? 1.0 : 1.0 / static_cast<double>(listeners_.size());
    }

    /// Weights the particles by their distance from each listener that they see.
    void find_near() {
        constexpr std::size_t kBlock = 64;  // particles of a job, a choice
        const std::span<const SoundParticle> all = particles_.all();
        workers_.run((all.size() + kBlock - 1) / kBlock, [&](std::size_t block) {
            for (std::size_t i = kBlock * block; i < std::min(all.size(), kBlock * (block + 1));
                 ++i) {
                const Vec3 position = all[i].position();
                for (std::size_t l = 0; l < listeners_.size(); ++l) {
                    const float share = glm::distance(position, listeners_[l]) / near_m_;
                    const bool is_near = share < 1 && all[i].energy.max() > 0 &&
                                         scene_.visible(position, listeners_[l]);
                    near_[l][i] = is_near ? 1 - share * share : 0;
                }
            }
        });
    }

    const RayScene& scene_;
    Bands attenuation_per_m_;
    float step_m_;
    float travelled_m_ = 0;
    std::span<const Vec3> listeners_;
    float near_m_;
    float slope_m_;
    WorkerPool& workers_;
    SoundParticles particles_;
    std::vector<std::vector<float>> near_;  ///< [listener][particle]
    std::vector<DecayHistory> at_;          ///< [listener]
    DecayHistory whole_;
};

}  // namespace

double sounding_length_s(const RayScene& scene, const Medium& medium, int order,
                         std::span<const Vec3> sources, std::span<const Vec3> listeners,
                         double longest_s, std::uint64_t seed, WorkerPool& workers) {
    Bounds bounds;
    bounds.add(sources);
    bounds.add(listeners);
    const auto speed_m_s = double{medium.speed_of_sound_m_s()};
    double length_s =
        std::max(kShortest_s, kAfterDirect_s + double{bounds.diagonal_m()} / speed_m_s);
    std::vector<Vec3> ends(sources.begin(), sources.end());
    ends.insert(ends.end(), listeners.begin(), listeners.end());
    const std::vector<Vec3> inside = inside_room(scene, ends, derive_seed(seed, 0));
    const auto free_path_m =
        static_cast<float>(survey_room(scene, inside, derive_seed(seed, 1)).mean_free_path_m);
    if (!(free_path_m > 0)) return std::min(length_s, longest_s);

    const auto places = [&](std::span<const Vec3> positions) {
        return far_apart(inside_room(scene, positions, derive_seed(seed, 2)));
    };
    std::uint64_t number = 3;
    const auto follow = [&](std::span<const Vec3> from, std::span<const Vec3> to) {
        for (const Vec3& start : from) {
            const std::size_t count = std::min(kParticles, kAllParticles / from.size());
            DecayObservation observation(
                scene, medium, to, free_path_m,
                SoundParticles(scene, order, start, count, derive_seed(seed, number++)), workers);
            length_s = std::max(length_s, observation.length_s(longest_s));
        }
    };
    const std::vector<Vec3> to = places(listeners);
    follow(places(sources), to);
    // Responses are reciprocal: what the room of a listener has to give, also to sources that come
    // later.
    follow(to, {});
    return std::min(length_s, longest_s);
}

}  // namespace aula
