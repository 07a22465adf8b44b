#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "aula/audio/output_options.h"
#include "aula/engine/bands.h"
#include "aula/engine/energy_response.h"
#include "aula/engine/scene.h"
#include "aula/engine/simulation.h"
#include "aula/engine/third_octaves.h"

namespace aula {

class BoxImages;
struct JoinedWaves;
struct OutputResources;

/// The parameters of a measurement, in the order of their columns. More may follow at the end.
enum class AcousticParameter {
    t20,         ///< T20 in s: reverberation time by the decay from -5 to -25 dB
    t30,         ///< T30 in s: reverberation time by the decay from -5 to -35 dB
    edt,         ///< EDT in s: early decay time, by the decay from 0 to -10 dB
    c50,         ///< C50 in dB: clarity, energy of the first 50 ms re that after them
    c80,         ///< C80 in dB: clarity, energy of the first 80 ms re that after them
    d50,         ///< D50: definition, share of the energy in the first 50 ms, 0..1
    ts,          ///< Ts in s: centre time
    g,           ///< G in dB: strength, re the free field at 10 m
    jlf,         ///< J_LF: early lateral energy fraction, with the axis perpendicular to the source
    jlfc,        ///< J_LFC: the same with the cosine of the angle of arrival instead of its square
    lj,          ///< L_J in dB: late lateral level, re the free field at 10 m
    iacc_early,  ///< IACC of the first 80 ms: interaural cross-correlation coefficient
    iacc_late    ///< IACC from 80 ms on
};

/// Number of acoustic parameters.
inline constexpr std::size_t kAcousticParameterCount = 13;

/// Number of the parameters that exist in third octaves: the first ones, from T20 to G.
inline constexpr std::size_t kThirdOctaveParameterCount = 8;

/// The name of a parameter in reports, for instance "T30".
std::string_view acoustic_parameter_name(AcousticParameter parameter);

/// The unit of a parameter: "s", "dB" or "".
std::string_view acoustic_parameter_unit(AcousticParameter parameter);

/// A value and its standard error, in the same unit. Neither is NaN or infinite.
struct MeasuredValue {
    std::optional<double> value;           ///< empty: the decay is not sufficient for it
    std::optional<double> standard_error;  ///< empty: unknown, as for a given number of frames
};

/// The parameters of one source at one receiver; all empty if the source is not audible there.
struct PairParameters {
    /// [parameter][band]
    std::array<std::array<MeasuredValue, kBandCount>, kAcousticParameterCount> octaves;

    /// [parameter] Single numbers by ISO 3382-1, annex A: means over the octaves of 500 and 1000
    /// Hz, for J_LF and J_LFC over those from 125 to 1000 Hz, for IACC over those from 500 to 2000
    /// Hz; for L_J the level of the mean energy from 125 to 1000 Hz.
    std::array<MeasuredValue, kAcousticParameterCount> broadband;

    /// [parameter][third octave] of the parameters from T20 to G; empty if omitted.
    std::vector<std::array<MeasuredValue, kThirdOctaveCount>> third_octaves;

    /// Speech transmission index by IEC 60268-16:2011, 0..1, with male weights.
    MeasuredValue sti;

    /// A parameter of an octave band; `band` < kBandCount is not checked.
    const MeasuredValue& octave(AcousticParameter parameter, std::size_t band) const {
        return octaves[static_cast<std::size_t>(parameter)][band];
    }
};

/// The largest accepted standard errors, in every octave from 125 Hz to 4 kHz.
struct MeasurementLimits {
    double level_db = 0.05;  ///< of the total energy, dB
    double c80_db = 0.1;     ///< of C80, dB
    double t30 = 0.01;       ///< of T30, relative
    double edt = 0.01;       ///< of EDT, relative
};

/// How a measurement is made. The settings of the propagation, such as the rays, are those of the
/// scene (Scene::simulation), and so are the levels for speech transmission indices
/// (Scene::speech).
struct MeasurementOptions {
    /// `max_work_s` of the program in normal quality: about a minute of two processors.
    static constexpr double kProgramWork_s = 120;

    /// Number of frames, at least 1. If absent: as many as needed for `limits`.
    std::optional<int> frames{};
    MeasurementLimits limits{};  ///< each above 0; not used with `frames`
    int max_frames = 2000;       ///< ends a measurement outside its limits; not used with `frames`
    /// Computation time of one processor in s, as counted from the work (docs/performance.md),
    /// with that of interaural coefficients, after which no further window begins, above 0; not
    /// used with `frames`. At least half of it, and two windows, are for the energy responses.
    double max_work_s = std::numeric_limits<double>::infinity();
    bool parameters = true;  ///< false omits Measurement::parameters
    /// True adds parameters in third octaves: surfaces interpolated between octaves, air exact.
    bool third_octaves = false;
    /// True adds the interaural coefficients, with binaural impulse responses of all pairs: the
    /// head, MIT KEMAR, faces the source. Their standard errors are those of the noise of the
    /// reverberation, not of the energy response. Otherwise they are empty.
    bool interaural = false;
    /// [receiver] Names for warnings_of(); empty: numbers.
    std::vector<std::string> receiver_names{};
    /// Called with the completed share of the computation, 0..1; returns false to stop. Empty:
    /// none.
    std::function<bool(double done)> progress{};
};

/// The responses of sources at receivers with everything at rest. A pair is a source and a
/// receiver; lists of pairs have the index [source * receivers.size() + receiver].
struct Measurement {
    std::vector<Source> sources;              ///< as measured
    std::vector<Pose> receivers;              ///< as measured
    std::vector<std::string> receiver_names;  ///< [receiver] of the options; empty: numbers
    Simulation simulation;                    ///< the settings of the propagation
    Medium medium;                            ///< the air of the scene
    std::vector<EnergyResponse> responses;    ///< [pair]
    std::vector<char> audible;                ///< [pair] 1 if the source is audible at the receiver
    std::vector<std::string> inaudible;       ///< [pair] why it is not audible; empty if it is
    /// [pair] The parameters with larger standard errors than wanted, each with its worst octave;
    /// empty if there are none, if the source is not audible, or for a given number of frames.
    std::vector<std::string> uncertain;
    std::vector<PairParameters> parameters;    ///< [pair]; empty if omitted
    double length_s = 0;                       ///< of the responses
    int frames = 0;                            ///< that were computed
    MeasurementLimits limits;                  ///< that were wanted
    double waves_below_hz = 0;                 ///< crossover of modes and rays; 0: rays alone
    std::shared_ptr<const JoinedWaves> waves;  ///< for ImpulseResponses; null: rays alone
    std::shared_ptr<const BoxImages> images;   ///< for ImpulseResponses; null: rays
    /// With "waves" on "auto": lines on sources for which rays are alone, and why.
    std::vector<std::string> without_waves;
    float patch_size_m = 0;  ///< as traced, where memory bounds it; 0: no patches
    /// Lines on octaves without T30, one for each reason; empty if parameters are omitted.
    std::vector<std::string> missing_decays;
    std::vector<std::string> warnings;  ///< lines on the measurement as a whole

    /// The index of a pair in the lists.
    std::size_t pair(std::size_t source, std::size_t receiver) const {
        return source * receivers.size() + receiver;
    }

    /// The energy response (echogram) of a pair; EnergyResponse::uniform gives it in equal bins.
    /// Gains of sources are not applied. Indices are not checked.
    const EnergyResponse& response(std::size_t source, std::size_t receiver = 0) const {
        return responses[pair(source, receiver)];
    }
};

/// Computes the energy responses of all sources at all receivers, at the poses of time 0. The rays
/// of a source serve all receivers. `sources` and `receivers` replace those of the scene; neither
/// is empty. The names of the sources seed the noise of their impulse responses and should differ.
///
/// With MeasurementOptions::frames: over that number of consecutive frames from empty caches.
/// Without: the mean over independent windows of frames, each from empty caches with a separate
/// seed, until the standard errors of level, C80, T30 and EDT of that mean are within the limits in
/// every octave from 125 Hz to 4 kHz for each audible pair, or until frames or their budget end.
///
/// The result of consecutive frames is the response after the last of them for `patch`, and the
/// mean of the responses after each of them for `pt` and `dpc-published`. For `dpc` it is the
/// former if the frames are at most 1.5 windows of its cache, else the latter.
///
/// An empty box whose walls scatter nothing is measured by all its image sources, without rays:
/// standard errors are 0; without modes, responses and parameters are exact.
///
/// A source is audible at a receiver if sound can reach it (random walks from both meet) and
/// is_audible() is true for its response. Returns empty if `progress` requested a stop. Throws
/// InputError.
std::optional<Measurement> measure(const Scene& scene, std::span<const Source> sources,
                                   std::span<const Pose> receivers,
                                   const MeasurementOptions& options = {});

/// The same for the sources and the listener of the scene.
std::optional<Measurement> measure(const Scene& scene, const MeasurementOptions& options = {});

/// The line for the user on a pair that is not audible or has larger errors than wanted; else
/// empty.
std::string pair_warning(const Measurement& measurement, std::size_t pair);

/// All lines for the user: those on the whole measurement, on pairs that are not audible or have
/// larger errors than wanted, and, last, on octaves without T30.
std::vector<std::string> warnings_of(const Measurement& measurement);

/// The options of a measurement in a quality, given those of Quality::normal: a draft has twice the
/// limits of standard errors, which take a quarter of the rays, and a quarter of the work; fine
/// quality has no limit of work.
MeasurementOptions within_budget(MeasurementOptions options, Quality quality);

/// Makes impulse responses from a measurement, as a renderer plays them for a listener at rest.
///
/// Several receivers are in one field: the omnidirectional reverberation of a source has the
/// coherence sin(kd) / (kd) of a diffuse field between receivers at the distance d (Habets et al.
/// 2008), and each further ambisonic channel, before it is rotated or decoded to ears, has the
/// same. For one receiver the reverberation is shaped from noise that depends on the source's name
/// and the seed only.
class ImpulseResponses {
 public:
    /// Keeps a reference to the measurement. Reads the HRTF and the headphones for binaural output,
    /// which is the default. The block affects rounding only. Throws InputError.
    ImpulseResponses(const Measurement& measurement, const OutputOptions& options);
    ~ImpulseResponses();
    ImpulseResponses(const ImpulseResponses&) = delete;
    ImpulseResponses& operator=(const ImpulseResponses&) = delete;

    /// The impulse response of a source at a receiver: [channel][sample], channel_count(output)
    /// channels. Sample 0 is the emission; the source's gain is applied. 1.0 is the pressure at a
    /// distance of 1 m in a free field. The length is that of the measurement, or longer if distant
    /// direct sound requires it, and longer by the filter of headphones. Indices are not checked.
    /// It is fastest source by source. [several threads]
    std::vector<std::vector<float>> response(std::size_t source, std::size_t receiver = 0) const;

 private:
    friend ImpulseResponses responses_with(const Measurement& measurement,
                                           const OutputResources& output);
    ImpulseResponses(const Measurement& measurement, const OutputResources& output);

    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
