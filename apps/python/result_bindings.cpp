#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <exception>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "apps/output/formatted.h"
#include "apps/output/printable.h"
#include "apps/python/arrays.h"
#include "apps/python/interruption.h"
#include "apps/python/overrides.h"
#include "apps/python/scene_bindings.h"
#include "apps/room/base/output_resources.h"
#include "apps/room/frames/signals.h"
#include "apps/room/offline/offline.h"
#include "audio/spatial/hrtf.h"
#include "aula/engine/impulse_response.h"
#include "aula/exception.h"
#include "aula/measurement.h"

namespace aula {

namespace {

using Response = std::vector<std::vector<float>>;  ///< [channel][sample]

/// The newest HRTF and noise carriers. Successive calls with one file, sample rate and seed then
/// share them: they are found by these while they are in use. With the interpreter's lock.
struct Kept {
    std::shared_ptr<const Hrtf> hrtf;
    std::shared_ptr<const NoiseCarriers> carriers;
};
Kept& kept() {
    static Kept newest;
    return newest;
}

Measurement measured(const SharedScene& shared, const std::vector<Source>& sources,
                     const Array<float>& receivers, std::optional<int> frames, int max_frames,
                     const std::array<double, 4>& limits, bool parameters, bool third_octaves,
                     bool interaural, const Overrides& overrides) {
    const std::shared_ptr<const Scene> scene = shared.get();
    std::vector<Pose> poses;
    for (py::ssize_t m = 0; m < receivers.shape(0); ++m)
        poses.push_back(pose_of(receivers.data() + 6 * m));
    const Scene changed = with(*scene, overrides);
    Interruption interruption;
    std::optional<Measurement> measurement;
    {
        const py::gil_scoped_release released;
        measurement = measure(changed, sources, poses,
                              {.frames = frames,
                               .limits = {.level_db = limits[0],
                                          .c80_db = limits[1],
                                          .t30 = limits[2],
                                          .edt = limits[3]},
                               .max_frames = max_frames,
                               .parameters = parameters,
                               .third_octaves = third_octaves,
                               .interaural = interaural,
                               .progress = [&](double) { return interruption.continues(); }});
    }
    interruption.rethrow();
    return std::move(*measurement);
}

/// A microphone of first order from first-order ambisonics W Y Z X: a W + (1 - a) X.
std::vector<float> first_order(const Response& foa, float omnidirectional_share) {
    std::vector<float> samples(foa[0].size());
    for (std::size_t i = 0; i < samples.size(); ++i)
        samples[i] = omnidirectional_share * foa[0][i] + (1 - omnidirectional_share) * foa[3][i];
    return samples;
}

/// Calls `make` with 0 to count - 1 on several threads, until there is a signal. Rethrows the first
/// exception.
void in_parallel(std::size_t count, int threads, Interruption& interruption, const auto& make) {
    std::atomic<std::size_t> next = 0;
    const std::thread::id caller = std::this_thread::get_id();
    const auto work = [&](std::exception_ptr& error) {
        try {
            for (std::size_t i = next++; i < count; i = next++) {
                make(i);
                if (std::this_thread::get_id() == caller && !interruption.continues()) next = count;
            }
        } catch (...) {
            error = std::current_exception();
            next = count;
        }
    };
    std::vector<std::exception_ptr> errors(
        std::min(std::max<std::size_t>(count, 1), static_cast<std::size_t>(threads)));
    {
        std::vector<std::jthread> workers;
        for (std::size_t t = 1; t < errors.size(); ++t)
            workers.emplace_back([&, t] { work(errors[t]); });
        work(errors[0]);
    }
    for (const std::exception_ptr& error : errors)
        if (error) std::rethrow_exception(error);
}

/// (S, M, channel, N); shorter responses end with zeros. `shares` has the omnidirectional share of
/// each microphone, for mono. Directional microphones, and all others beside them, are made from
/// ambisonics.
py::array_t<float> impulse_responses(const Measurement& measurement, double sample_rate_hz,
                                     const std::string& output, const std::string& hrtf,
                                     int ambisonic_order, const std::vector<float>& shares,
                                     int threads) {
    const std::size_t receivers = measurement.receivers.size();
    std::vector<Response> responses(measurement.responses.size());
    const OutputOptions options{.sample_rate_hz = sample_rate_hz,
                                .output = output_of(output),
                                .ambisonic_order = ambisonic_order,
                                .hrtf = hrtf};
    const bool mono = options.output == OutputFormat::mono;
    Interruption interruption;
    Kept used;
    {
        const py::gil_scoped_release released;
        used.hrtf = hrtf_for(options);
        const ImpulseResponses plain(measurement, options);
        OutputOptions foa_options = options;
        foa_options.output = OutputFormat::foa;
        std::optional<ImpulseResponses> foa;
        if (mono &&
            std::any_of(shares.begin(), shares.end(), [](float share) { return share != 1; }))
            foa.emplace(measurement, foa_options);
        if (receivers == 1 && !measurement.images)
            used.carriers = make_noise_carriers(sample_rate_hz, measurement.simulation.seed);
        in_parallel(responses.size(), threads, interruption, [&](std::size_t pair) {
            const std::size_t s = pair / receivers;
            const std::size_t m = pair % receivers;
            responses[pair] =
                foa ? Response{first_order(foa->response(s, m), shares[m])} : plain.response(s, m);
        });
    }
    interruption.rethrow();
    if (used.hrtf) kept().hrtf = used.hrtf;
    if (used.carriers) kept().carriers = used.carriers;
    std::size_t samples = 0;
    for (const Response& response : responses) samples = std::max(samples, response[0].size());
    const std::size_t channels = channel_count(options.output);
    py::array_t<float> array(
        std::vector<std::size_t>{measurement.sources.size(), receivers, channels, samples});
    float* to = array.mutable_data();
    for (Response& response : responses) {
        for (const std::vector<float>& channel : response) {
            std::fill(std::copy(channel.begin(), channel.end(), to), to + samples, 0.0F);
            to += samples;
        }
        response.clear();
    }
    return array;
}

/// Values and standard errors; NaN where there is none.
class ValueArrays {
 public:
    explicit ValueArrays(const std::vector<std::size_t>& shape) : values_(shape), errors_(shape) {}

    void add(const MeasuredValue& measured) {
        constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
        values_.mutable_data()[count_] = measured.value.value_or(kNone);
        errors_.mutable_data()[count_++] = measured.standard_error.value_or(kNone);
    }
    py::tuple arrays() const { return py::make_tuple(values_, errors_); }

 private:
    py::array_t<double> values_, errors_;
    std::size_t count_ = 0;
};

/// {name: (values, standard errors)} of the third octaves, (S, M, 26), from T20 to G; empty if they
/// were not measured.
py::dict third_octaves(const Measurement& measurement) {
    const auto& all = measurement.parameters;
    const bool is_measured = std::any_of(all.begin(), all.end(), [](const PairParameters& pair) {
        return !pair.third_octaves.empty();
    });
    py::dict thirds;
    for (std::size_t p = 0; is_measured && p < kThirdOctaveParameterCount; ++p) {
        ValueArrays values(std::vector<std::size_t>{
            measurement.sources.size(), measurement.receivers.size(), kThirdOctaveCount});
        for (const PairParameters& pair : all)
            for (std::size_t t = 0; t < kThirdOctaveCount; ++t)
                values.add(pair.third_octaves.empty() ? MeasuredValue{} : pair.third_octaves[p][t]);
        thirds[py::str(std::string(acoustic_parameter_name(static_cast<AcousticParameter>(p))))] =
            values.arrays();
    }
    return thirds;
}

/// {name: (values, standard errors)} of the octave bands, (S, M, 8), of the single numbers, (S, M),
/// with STI, and of the third octaves.
py::tuple parameters(const Measurement& measurement) {
    const std::vector<std::size_t> pairs{measurement.sources.size(), measurement.receivers.size()};
    const std::vector<std::size_t> bands{pairs[0], pairs[1], kBandCount};
    py::dict octaves, single_numbers;
    for (std::size_t p = 0; p < kAcousticParameterCount; ++p) {
        ValueArrays of_octaves(bands), single(pairs);
        for (const PairParameters& pair : measurement.parameters) {
            for (const MeasuredValue& octave : pair.octaves[p]) of_octaves.add(octave);
            single.add(pair.broadband[p]);
        }
        const py::str name(std::string(acoustic_parameter_name(static_cast<AcousticParameter>(p))));
        octaves[name] = of_octaves.arrays();
        single_numbers[name] = single.arrays();
    }
    ValueArrays sti(pairs);
    for (const PairParameters& pair : measurement.parameters) sti.add(pair.sti);
    single_numbers["STI"] = sti.arrays();
    return py::make_tuple(octaves, single_numbers, third_octaves(measurement));
}

/// The columns of all discrete paths, (P,), (P, 3) and (P, 8), pair by pair.
py::dict paths(const Measurement& measurement) {
    std::size_t count = 0;
    for (const EnergyResponse& response : measurement.responses) count += response.paths.size();
    const auto whole = [&] { return py::array_t<int>(std::vector<std::size_t>{count}); };
    const auto vectors = [&](std::size_t width) {
        return py::array_t<float>(std::vector<std::size_t>{count, width});
    };
    py::array_t<int> source = whole(), microphone = whole(), order = whole(), edges = whole();
    py::array_t<double> delay_s(std::vector<std::size_t>{count});
    py::array_t<std::uint64_t> key(std::vector<std::size_t>{count});
    py::array_t<float> arrival = vectors(3), departure = vectors(3), energy = vectors(kBandCount);
    py::list kind;
    std::size_t row = 0;
    for (std::size_t pair = 0; pair < measurement.responses.size(); ++pair) {
        const EnergyResponse& response = measurement.responses[pair];
        for (const SoundPath& path : response.paths) {
            constexpr std::array kKinds{"direct", "image", "bent", "through_walls"};
            kind.append(kKinds[static_cast<std::size_t>(path.kind)]);
            source.mutable_data()[row] = static_cast<int>(pair / measurement.receivers.size());
            microphone.mutable_data()[row] = static_cast<int>(pair % measurement.receivers.size());
            order.mutable_data()[row] = path.order;
            edges.mutable_data()[row] = path.edges;
            delay_s.mutable_data()[row] = response.arrival_s(path);
            key.mutable_data()[row] = path.key;
            std::copy_n(&path.direction[0], 3, arrival.mutable_data() + 3 * row);
            std::copy_n(&path.departure[0], 3, departure.mutable_data() + 3 * row);
            std::copy(path.energy.value.begin(), path.energy.value.end(),
                      energy.mutable_data() + kBandCount * row);
            ++row;
        }
    }
    py::dict columns;
    columns["source"] = source;
    columns["microphone"] = microphone;
    columns["kind"] = py::module_::import("numpy").attr("array")(kind, "U13");
    columns["order"] = order;
    columns["edges"] = edges;
    columns["delay_s"] = delay_s;
    columns["arrival"] = arrival;
    columns["departure"] = departure;
    columns["energy"] = energy;
    columns["key"] = key;
    return columns;
}

/// (S, M, 8, bin), 1/m2 per unit emitted energy.
py::array_t<float> energy(const Measurement& measurement, double bin_s) {
    std::vector<std::vector<Bands>> echograms;
    {
        const py::gil_scoped_release released;
        for (const EnergyResponse& response : measurement.responses)
            echograms.push_back(response.uniform(bin_s));
    }
    std::size_t bins = 0;
    for (const auto& echogram : echograms) bins = std::max(bins, echogram.size());
    py::array_t<float> array(std::vector<std::size_t>{
        measurement.sources.size(), measurement.receivers.size(), kBandCount, bins});
    float* to = array.mutable_data();
    for (const auto& echogram : echograms)
        for (std::size_t band = 0; band < kBandCount; ++band)
            for (std::size_t bin = 0; bin < bins; ++bin)
                *to++ = bin < echogram.size() ? echogram[bin][band] : 0;
    return array;
}

/// Samples (channel, N) and warnings.
py::tuple rendered(const SharedScene& shared, const std::map<std::string, Array<float>>& samples,
                   double sample_rate_hz, const std::string& output, const std::string& hrtf,
                   int ambisonic_order, std::optional<double> duration_s,
                   std::uint64_t max_memory_bytes, const Overrides& overrides) {
    const Scene scene = with(*shared.get(), overrides);
    SignalSet signals;
    SharedSignals files(scene, sample_rate_hz);
    for (std::size_t s = 0; s < scene.sources.size(); ++s) {
        const Source& source = scene.sources[s];
        const auto given = samples.find(source.name);
        if (given != samples.end()) {
            const float* const first = given->second.data();
            signals.push_back(std::make_shared<const Signal>(
                std::vector<float>(first, first + given->second.size()), source.loop));
        } else if (source.signal == Source::Signal::file && source.signal_file.empty()) {
            signals.push_back(std::make_shared<const Signal>(std::vector<float>{}, false));
        } else {
            signals.push_back(files.read(s));
        }
    }
    PlaybackOptions options{output_options(sample_rate_hz, output, hrtf, ambisonic_order)};
    options.duration_s = duration_s;
    options.max_memory_bytes = max_memory_bytes;

    std::vector<std::string> warnings = printable_lines(warnings_of(signals));
    std::unique_ptr<OfflineRendering> rendering;
    {
        const py::gil_scoped_release released;
        rendering = std::make_unique<OfflineRendering>(scene, std::move(signals), options);
    }
    const auto count = static_cast<std::size_t>(rendering->samples());
    py::array_t<float> array(std::vector<std::size_t>{channel_count(options.output), count});
    float* const to = array.mutable_data();
    std::size_t done = 0;
    Interruption interruption;
    {
        const py::gil_scoped_release released;
        rendering->render(
            [&](std::span<const std::span<const float>> channels) {
                for (std::size_t c = 0; c < channels.size(); ++c)
                    std::copy(channels[c].begin(), channels[c].end(), to + c * count + done);
                done += channels[0].size();
            },
            [&](double) { return interruption.continues(); });
        if (const std::int64_t muted = rendering->status().muted_samples; muted > 0)
            warnings.push_back(muted_text(muted));
        rendering.reset();
    }
    interruption.rethrow();
    return py::make_tuple(array, warnings);
}

}  // namespace

void bind_results(py::module_& module) {
    py::class_<Overrides>(module, "Overrides")
        .def(py::init([](std::optional<std::uint64_t> seed, std::optional<int> rays,
                         std::optional<float> ir_length_s, int threads,
                         std::optional<Array<float>> speech_db,
                         std::optional<Array<float>> noise_db) {
            return Overrides{seed, rays, ir_length_s, speech_db, noise_db, threads};
        }));
    py::class_<Measurement>(module, "Measurement")
        .def("impulse_responses", &impulse_responses)
        .def("parameters", &parameters)
        .def("energy", &energy)
        .def("paths", &paths)
        .def_readonly("frames", &Measurement::frames)
        .def_readonly("length_s", &Measurement::length_s)
        .def_property_readonly("warnings",
                               [](const Measurement& m) {
                                   std::vector<std::string> lines = warnings_of(m);
                                   lines.resize(lines.size() - m.missing_decays.size());
                                   return printable_lines(lines);
                               })
        .def_property_readonly(
            "missing_decays",
            [](const Measurement& m) { return printable_lines(m.missing_decays); })
        .def("audible", [](const Measurement& measurement) {
            py::array_t<bool> array(
                std::vector<std::size_t>{measurement.sources.size(), measurement.receivers.size()});
            std::copy(measurement.audible.begin(), measurement.audible.end(), array.mutable_data());
            return array;
        });
    module.def("measure", &measured);
    module.def("render", &rendered);
}

}  // namespace aula
