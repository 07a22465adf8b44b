#include "apps/session/measurement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>

#include "apps/session/sound_at_listener.h"
#include "audio/realtime.h"
#include "engine/impulse_response.h"
#include "engine/propagation.h"
#include "engine/sampling.h"

namespace aula {

namespace {

constexpr double kWantedError_db = 0.1;
constexpr int kMostFrames = 2000;
/// Fewer windows say little about their own spread.
constexpr std::size_t kFewestWindows = 8;
/// For what filters add behind the last arrival.
constexpr double kFilterTail_s = 0.05;

/// The running sum of responses with the same bins. A discrete path counts in the frames that have
/// it.
class ResponseSum {
 public:
    void add(const EnergyResponse& response) {
        if (count_++ == 0) {
            first_ = response;
            energy_.resize(response.energy.size());
            direction_.resize(response.direction.size());
        }
        for (std::size_t bin = 0; bin < energy_.size(); ++bin) {
            for (std::size_t band = 0; band < kBandCount; ++band)
                energy_[bin][band] += static_cast<double>(response.energy[bin][band]);
            direction_[bin] += glm::dvec3(response.direction[bin]);
        }
        for (const SpecularPath& path : response.paths) {
            PathSum& sum = paths_.try_emplace(path.id, PathSum{path, {}}).first->second;
            for (std::size_t band = 0; band < kBandCount; ++band)
                sum.energy[band] += static_cast<double>(path.energy[band]);
        }
    }

    EnergyResponse mean() const {
        EnergyResponse mean = first_;
        const double share = 1.0 / count_;
        for (std::size_t bin = 0; bin < energy_.size(); ++bin) {
            mean.energy[bin] = bands(energy_[bin], share);
            mean.direction[bin] = Vec3(direction_[bin] * share);
        }
        mean.paths.clear();
        for (const auto& [id, sum] : paths_) {
            mean.paths.push_back(sum.path);
            mean.paths.back().energy = bands(sum.energy, share);
        }
        std::stable_sort(
            mean.paths.begin(), mean.paths.end(),
            [](const SpecularPath& a, const SpecularPath& b) { return a.length_m < b.length_m; });
        return mean;
    }

 private:
    using Sums = std::array<double, kBandCount>;
    struct PathSum {
        SpecularPath path;
        Sums energy;
    };

    static Bands bands(const Sums& sums, double share) {
        Bands out;
        for (std::size_t band = 0; band < kBandCount; ++band)
            out[band] = static_cast<float>(sums[band] * share);
        return out;
    }

    int count_ = 0;
    EnergyResponse first_;
    std::vector<Sums> energy_;
    std::vector<glm::dvec3> direction_;
    std::map<std::uint64_t, PathSum> paths_;
};

/// The energies of independent windows, and how well they determine their mean's level.
class LevelError {
 public:
    void add(double energy) {
        ++count_;
        const double step = energy - mean_;
        mean_ += step / static_cast<double>(count_);
        squares_ += step * (energy - mean_);
    }

    /// Standard error of the mean's level; 0 for silence.
    double standard_error_db() const {
        if (mean_ <= 0) return 0;
        const auto n = static_cast<double>(count_);
        const double relative = std::sqrt(squares_ / (n - 1) / n) / mean_;
        return 10 / std::log(10.0) * relative;
    }

 private:
    std::size_t count_ = 0;
    double mean_ = 0;
    double squares_ = 0;  ///< sum of squared deviations from the mean
};

/// Steps one propagation with everything standing still.
class StandingStill {
 public:
    explicit StandingStill(const Scene& scene)
        : propagation_(scene, scene.simulation), sums_(scene.sources.size()) {
        input_.listeners = {scene.listener.pose_at(0).position};
        for (const Source& source : scene.sources) input_.sources.push_back(source.position_at(0));
    }

    void restart(std::uint64_t seed) { propagation_.restart(seed); }

    void step() {
        propagation_.step(input_);
        for (std::size_t s = 0; s < sums_.size(); ++s) sums_[s].add(propagation_.response(s));
        ++frames_;
    }

    const EnergyResponse& response(std::size_t source) const {
        return propagation_.response(source);
    }

    int frames() const { return frames_; }

    Measurement result() const {
        Measurement m{
            .responses = {}, .length_s = propagation_.response_length_s(), .frames = frames_};
        for (const ResponseSum& sum : sums_) m.responses.push_back(sum.mean());
        return m;
    }

 private:
    Propagation propagation_;
    FrameInput input_;
    std::vector<ResponseSum> sums_;
    int frames_ = 0;
};

}  // namespace

std::optional<Measurement> measure(const Scene& scene, std::optional<int> frames,
                                   const Progress& progress) {
    StandingStill still(scene);
    const int most = frames.value_or(kMostFrames);
    const int window = frames ? *frames : scene.simulation.window_frames();
    std::vector<LevelError> errors(scene.sources.size() * kBandCount);
    for (std::size_t windows = 0; still.frames() < most; ++windows) {
        if (windows > 0) still.restart(derive_seed(scene.simulation.seed, windows));
        std::vector<double> energies(errors.size());
        const int count = std::min(window, most - still.frames());
        for (int f = 0; f < count; ++f) {
            still.step();
            for (std::size_t i = 0; i < energies.size(); ++i)
                energies[i] += still.response(i / kBandCount).total(i % kBandCount);
            if (progress && !progress(static_cast<double>(still.frames()) / most))
                return std::nullopt;
        }
        double worst_db = 0;
        for (std::size_t i = 0; i < errors.size(); ++i) {
            errors[i].add(energies[i] / count);
            worst_db = std::max(worst_db, errors[i].standard_error_db());
        }
        if (windows + 1 >= kFewestWindows && worst_db < kWantedError_db) break;
    }
    return still.result();
}

std::vector<std::vector<float>> impulse_response(const Scene& scene, std::size_t source,
                                                 const Measurement& measurement,
                                                 const SessionOptions& options,
                                                 const std::shared_ptr<const Hrtf>& hrtf) {
    const FlushDenormals flush;
    const double rate_hz = options.sample_rate_hz;
    const EnergyResponse& energy = measurement.responses[source];
    RendererConfig config = renderer_config(scene, measurement.length_s, rate_hz, options);
    config.sources = 1;
    ImpulseResponseBuilder builder(
        std::make_shared<const NoiseCarriers>(rate_hz, scene.simulation.seed), measurement.length_s,
        scene.sources[source].name, field_order(config));
    ImpulseResponse response;
    builder.build(energy, response);
    const SourceSound sound = source_sound(response, static_cast<double>(energy.speed_of_sound_m_s),
                                           scene.sources[source].gain_db);

    const HeadRotation head = head_rotation(scene.listener.pose_at(0));
    Renderer renderer(config, hrtf);
    RenderFrameBuilder frames(config, hrtf);
    auto frame = frames.make_frame();
    frames.prepare({&sound, 1}, *frame);
    renderer.mailbox().publish(std::move(frame));

    auto length = static_cast<std::size_t>(std::ceil(measurement.length_s * rate_hz));
    if (sound.direct && sound.direct->delay_s > measurement.length_s - kFilterTail_s)
        length = std::max(
            length, static_cast<std::size_t>((sound.direct->delay_s + kFilterTail_s) * rate_hz));
    const auto block = static_cast<std::size_t>(options.block);
    const std::size_t blocks = (length + block - 1) / block;
    std::vector<std::vector<float>> channels(channel_count(options.output),
                                             std::vector<float>(blocks * block));
    std::vector<float> input(block);
    input[0] = 1;
    std::vector<float*> outputs;
    outputs.reserve(channels.size());
    for (std::size_t first = 0; first < length; first += block) {
        outputs.clear();
        for (auto& channel : channels) outputs.push_back(channel.data() + first);
        const std::array<const float*, 1> inputs{input.data()};
        renderer.render(inputs, head, outputs, options.block);
        input[0] = 0;
    }
    for (auto& channel : channels) channel.resize(length);
    return channels;
}

}  // namespace aula
