#include "apps/room/waves/wave_synthesis.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>
#include <vector>

#include "audio/dsp/fft.h"
#include "engine/tail/carrier_interpolator.h"
#include "process/multiversion.h"

namespace aula {

namespace {

/// The corner of the high-pass filter, below all bands.
constexpr double kLowest_hz = 8;

/// The interpolator passes frequencies up to this share of its input's rate, as those of the low
/// noise carriers.
constexpr double kInterpolated = 0.26;

/// Frequencies that are computed together.
constexpr std::size_t kTogether = 16;
using Together = float __attribute__((vector_size(kTogether * sizeof(float))));

/// The bands that masks reach, up to the octave above the highest crossover.
constexpr std::size_t kBands = 5;

/// A path, at kTogether frequencies.
struct PathTerm {
    std::array<float, kBands> amplitude{};             ///< of the octaves
    std::array<float, 4> channel{};                    ///< factors of W, X, Y and Z
    std::array<float, kTogether> real{}, imaginary{};  ///< the phases re the first frequency
};

/// Adds a path at kTogether frequencies from `first` on; `real` and `imaginary`: the phase there.
AULA_MULTIVERSION void add_phases(const PathTerm& term, const std::vector<float>* weights,
                                  std::size_t first, float real, float imaginary,
                                  std::vector<float>* sums) {
    const auto load = [](const float* from) {
        Together value;
        std::memcpy(&value, from, sizeof value);
        return value;
    };
    Together amplitude{};
    for (std::size_t b = 0; b < kBands; ++b)
        amplitude += term.amplitude[b] * load(weights[b].data() + first);
    const Together cosine = load(term.real.data());
    const Together sine = load(term.imaginary.data());
    const Together parts[2] = {amplitude * (real * cosine - imaginary * sine),
                               amplitude * (real * sine + imaginary * cosine)};
    for (std::size_t i = 0; i < 8; ++i) {
        float* const to = sums[i].data() + first;
        const Together sum = load(to) + term.channel[i / 2] * parts[i % 2];
        std::memcpy(to, &sum, sizeof sum);
    }
}

/// Gives the octaves with centres below the crossover the energy of the next one. Below it the path
/// is taken out, and its filter then has no phase there.
void flatten_below(double crossover_hz, Bands& energy) {
    std::size_t band = 0;
    while (band + 1 < kBandCount && double{kBandCentres_hz[band]} < crossover_hz) ++band;
    for (std::size_t below = 0; below < band; ++below) energy[below] = energy[band];
}

std::size_t decimation_for(double end_hz, double sample_rate_hz) {
    const double most = std::max(1.0, kInterpolated * sample_rate_hz / end_hz);
    return std::bit_floor(static_cast<std::size_t>(most));
}

}  // namespace

std::complex<double> wave_high_pass(std::complex<double> s) {
    const std::complex<double> x = s / kLowest_hz;
    const auto section = [&](double angle) {
        return x * x / (x * x + 2 * std::cos(angle) * x + 1.0);
    };
    return section(std::numbers::pi / 8) * section(3 * std::numbers::pi / 8);
}

/// The field below one crossover.
class WaveSynthesis::Field {
 public:
    Field(const WaveMasks& masks, double sample_rate_hz, std::size_t length_samples);

    double crossover_hz() const { return crossover_hz_; }

    /// Adds the field of a pair to the channels up to the first order of a response. Its paths are
    /// taken out below the crossover; the channels are those of rays and end there, or are taken
    /// out as well.
    void add(const PairWaves& waves, const std::function<double(const SoundPath&)>& delay_s,
             bool without_channels, ImpulseResponse& response);

 private:
    /// [real and imaginary part of W, X, Y and Z][frequency]
    using Sums = std::array<std::vector<float>, 8>;

    void add_path(const SoundPath& path, double delay_s, Sums& sums) const;
    void add_channel(const std::vector<float>& channel, std::size_t component, Sums& sums) const;
    /// The sample of the transform that is a sample of the interpolator's input.
    std::size_t index_of(std::size_t decimated) const {
        return (decimated + fft_.size() - CarrierInterpolator::kBefore) % fft_.size();
    }

    double crossover_hz_;
    std::size_t decimation_;  ///< from the sample rate to that of the field, a power of two
    WaveTransform transform_;
    RealFft fft_;
    std::size_t frequencies_;  ///< below the end of the masks; in the work spaces rounded up
    CarrierInterpolator interpolator_;
    std::vector<std::complex<double>> low_pass_;   ///< [frequency] the mask and the FFT's factor
    std::vector<std::complex<double>> high_pass_;  ///< [frequency]
    std::vector<std::vector<float>> octaves_;      ///< [band][frequency] weights of the octaves
    Sums seen_, played_;  ///< work space: the direct sound, and what is played
    std::vector<std::complex<float>> spectrum_;    ///< work space
    std::vector<float> growth_;                    ///< [sample of the interpolator's input]
    std::vector<float> field_, decimated_, full_;  ///< work space
};

WaveSynthesis::Field::Field(const WaveMasks& masks, double sample_rate_hz,
                            std::size_t length_samples)
    : crossover_hz_(masks.crossover_hz),
      decimation_(decimation_for(masks.end_hz(), sample_rate_hz)),
      transform_(static_cast<double>(length_samples) / sample_rate_hz,
                 sample_rate_hz / static_cast<double>(decimation_)),
      fft_(transform_.size),
      frequencies_(std::min(fft_.bins(),
                            static_cast<std::size_t>(masks.end_hz() / transform_.step_hz()) + 1)),
      interpolator_(decimation_),
      octaves_(kBands),
      spectrum_(fft_.bins()),
      field_(fft_.size()) {
    const std::size_t rounded = (frequencies_ + kTogether - 1) / kTogether * kTogether;
    for (std::vector<float>& weights : octaves_) weights.resize(rounded);
    for (std::size_t k = 0; k < frequencies_; ++k) {
        const double hz = static_cast<double>(k) * transform_.step_hz();
        low_pass_.push_back(masks.low(hz) / static_cast<double>(decimation_ * fft_.size()));
        high_pass_.push_back(wave_high_pass({transform_.decay_per_s / (2 * std::numbers::pi), hz}));
        // As path_amplitude().
        const double octave = std::clamp(std::log2(std::max(hz, 1.0) / double{kBandCentres_hz[0]}),
                                         0.0, static_cast<double>(kBands - 1));
        const std::size_t below = std::min(static_cast<std::size_t>(octave), kBands - 2);
        const double share = octave - static_cast<double>(below);
        octaves_[below][k] = static_cast<float>(1 - share);
        octaves_[below + 1][k] = static_cast<float>(share);
    }
    for (Sums* const sums : {&seen_, &played_})
        for (std::vector<float>& sum : *sums) sum.resize(rounded);
    const std::size_t count = (length_samples + decimation_ - 1) / decimation_;
    for (std::size_t i = 0; i < CarrierInterpolator::kBefore + count + CarrierInterpolator::kAfter;
         ++i)
        growth_.push_back(transform_.growth(index_of(i)));
    decimated_.resize(growth_.size());
    full_.resize(count * decimation_);
}

void WaveSynthesis::Field::add_path(const SoundPath& path, double delay_s, Sums& sums) const {
    const double step = -2 * std::numbers::pi * transform_.step_hz() * delay_s;
    const auto decayed = static_cast<float>(std::exp(-transform_.decay_per_s * delay_s));
    PathTerm term;
    for (std::size_t b = 0; b < kBands; ++b)
        term.amplitude[b] = decayed * std::sqrt(squared_pressure(path.energy[b]));
    term.channel = {1, path.direction.x, path.direction.y, path.direction.z};
    for (std::size_t i = 0; i < kTogether; ++i) {
        term.real[i] = static_cast<float>(std::cos(step * static_cast<double>(i)));
        term.imaginary[i] = static_cast<float>(std::sin(step * static_cast<double>(i)));
    }
    const std::complex<double> turn = std::polar(1.0, step * static_cast<double>(kTogether));
    std::complex<double> phase = 1;
    for (std::size_t first = 0; first < sums[0].size(); first += kTogether) {
        best_version<add_phases>(term, octaves_.data(), first, static_cast<float>(phase.real()),
                                 static_cast<float>(phase.imag()), sums.data());
        phase *= turn;
    }
}

/// Adds the spectrum of a channel of the response, W, X, Y or Z.
void WaveSynthesis::Field::add_channel(const std::vector<float>& channel, std::size_t component,
                                       Sums& sums) const {
    RealFft fft(transform_.size * decimation_);
    std::vector<float> signal(fft.size());
    const double per_sample =
        transform_.decay_per_s / (transform_.rate_hz * static_cast<double>(decimation_));
    for (std::size_t n = 0; n < channel.size(); ++n)
        signal[n] = channel[n] * static_cast<float>(std::exp(-per_sample * static_cast<double>(n)));
    std::vector<std::complex<float>> spectrum(fft.bins());
    fft.forward(signal.data(), spectrum.data());
    for (std::size_t k = 0; k < frequencies_; ++k) {
        sums[2 * component][k] += spectrum[k].real();
        sums[2 * component + 1][k] += spectrum[k].imag();
    }
}

void WaveSynthesis::Field::add(const PairWaves& waves,
                               const std::function<double(const SoundPath&)>& delay_s,
                               bool without_channels, ImpulseResponse& response) {
    for (Sums* const sums : {&seen_, &played_})
        for (std::vector<float>& sum : *sums) std::fill(sum.begin(), sum.end(), 0.0F);
    if (waves.direct()) add_path(*waves.direct(), delay_s(*waves.direct()), seen_);
    for (const SoundPath& path : response.paths) {
        // The modes know no transmission.
        if (path.kind != SoundPath::Kind::through_walls) add_path(path, delay_s(path), played_);
    }
    const WaveSpectra field = waves.field(transform_, frequencies_);
    constexpr std::array<std::size_t, 4> kChannel{0, 3, 1, 2};  // of W, x, y and z (ACN)
    for (std::size_t c = 0; without_channels && c < 4; ++c)
        if (kChannel[c] < response.channels.size())
            add_channel(response.channels[kChannel[c]], c, played_);
    for (std::size_t c = 0; c < 4; ++c) {
        if (kChannel[c] >= response.channels.size()) continue;
        const auto part = [&](const Sums& sums, std::size_t k) {
            return std::complex<double>(double{sums[2 * c][k]}, double{sums[2 * c + 1][k]});
        };
        std::fill(spectrum_.begin(), spectrum_.end(), 0.0F);
        // The field at 0 Hz, which the high-pass filter leaves out, is 0 there.
        for (std::size_t k = 0; k < frequencies_; ++k) {
            const std::complex<double> seen = part(seen_, k);
            const std::complex<double> rest =
                high_pass_[k] * (field[c][k] + seen) - part(played_, k);
            spectrum_[k] = std::complex<float>(low_pass_[k] * rest);
        }
        fft_.inverse(spectrum_.data(), field_.data());
        for (std::size_t i = 0; i < decimated_.size(); ++i) {
            decimated_[i] = field_[index_of(i)] * growth_[i];
        }
        std::vector<float>& channel = response.channels[kChannel[c]];
        interpolator_.process(decimated_.data(), (channel.size() + decimation_ - 1) / decimation_,
                              full_.data());
        for (std::size_t i = 0; i < channel.size(); ++i) channel[i] += full_[i];
    }
}

WaveSynthesis::WaveSynthesis(double sample_rate_hz, std::size_t length_samples)
    : sample_rate_hz_(sample_rate_hz), length_samples_(length_samples) {}

WaveSynthesis::~WaveSynthesis() = default;

void WaveSynthesis::build(ImpulseResponseBuilder& builder, const EnergyResponse& rays,
                          const std::optional<PairWaves>& modes,
                          const std::function<double(const SoundPath&)>& delay_s,
                          ImpulseResponse& out, TailScale* scale, std::size_t samples) {
    builder.build(rays, out, modes ? modes->masks().crossover_hz : 0, scale, samples);
    if (modes) field_below(*modes, out).add(*modes, delay_s, false, out);
}

void WaveSynthesis::replace_below(const PairWaves& modes,
                                  const std::function<double(const SoundPath&)>& delay_s,
                                  ImpulseResponse& response) {
    field_below(modes, response).add(modes, delay_s, true, response);
}

/// The field below the crossover, which the paths of a response are prepared for.
WaveSynthesis::Field& WaveSynthesis::field_below(const PairWaves& modes, ImpulseResponse& out) {
    for (SoundPath& path : out.paths)
        if (path.kind != SoundPath::Kind::through_walls)
            flatten_below(modes.masks().crossover_hz, path.energy);
    if (!field_ || field_->crossover_hz() != modes.masks().crossover_hz)
        field_ = std::make_unique<Field>(modes.masks(), sample_rate_hz_, length_samples_);
    return *field_;
}

}  // namespace aula
