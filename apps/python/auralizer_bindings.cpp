#include "aula/auralizer.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "apps/python/arrays.h"
#include "apps/python/interruption.h"
#include "apps/python/overrides.h"
#include "apps/python/scene_bindings.h"

namespace aula {

namespace {

/// An object of a scene by its index or its name.
using ObjectKey = std::variant<std::size_t, std::string>;

/// An auralizer of Python, which keeps the settings of its scenes. Several threads of Python may
/// use it at the same time.
class PythonAuralizer {
 public:
    /// `overrides`: without levels, which only measurements use.
    PythonAuralizer(const Scene& scene, AuralizerOptions options, Overrides overrides)
        : overrides_(std::move(overrides)), auralizer_(scene, std::move(options)) {}

    /// The auralizer. Throws what has ended its propagation.
    Auralizer* operator->() {
        static_cast<void>(auralizer_.status());
        return &auralizer_;
    }

    const Overrides& overrides() const { return overrides_; }

    void render(std::span<const SourceSignal> inputs, std::span<float* const> outputs,
                int samples) {
        const std::lock_guard lock(rendering_);
        (*this)->render(inputs, outputs, samples);
    }

 private:
    const Overrides overrides_;
    std::mutex rendering_;
    Auralizer auralizer_;
};

/// Destroys an auralizer without the interpreter's lock: it waits for the frame in progress.
struct DestroyReleased {
    void operator()(PythonAuralizer* auralizer) const {
        const py::gil_scoped_release released;
        delete auralizer;
    }
};
using Holder = std::unique_ptr<PythonAuralizer, DestroyReleased>;

Holder make_auralizer(const SharedScene& shared, double sample_rate_hz, const std::string& output,
                      const std::string& hrtf, int ambisonic_order, const std::string& headphones,
                      bool is_exact, std::size_t max_sources, std::uint64_t max_memory_bytes,
                      const Overrides& overrides) {
    const Scene scene = with(*shared.get(), overrides);
    AuralizerOptions options{output_options(sample_rate_hz, output, hrtf, ambisonic_order)};
    options.headphones = headphones;
    options.clock = is_exact ? RenderClock::exact : RenderClock::real_time;
    options.max_sources = max_sources;
    options.max_memory_bytes = max_memory_bytes;
    Overrides kept = overrides;
    kept.speech_db.reset();
    kept.noise_db.reset();
    const py::gil_scoped_release released;
    return Holder(new PythonAuralizer(scene, std::move(options), std::move(kept)));
}

std::uint64_t add_source(PythonAuralizer& auralizer, const Source& source) {
    const Pose pose = source.pose_at(0);
    const py::gil_scoped_release released;
    const SourceId added = auralizer->add_source({.position = pose.position,
                                                  .yaw_rad = pose.yaw_rad,
                                                  .pitch_rad = pose.pitch_rad,
                                                  .roll_rad = pose.roll_rad,
                                                  .directivity = source.directivity,
                                                  .gain_db = source.gain_db,
                                                  .name = source.name});
    static_cast<void>(auralizer->status());  // of a propagation that has failed meanwhile
    return added.number;
}

/// Samples between two checks for Ctrl-C: a frame at 30 Hz and 48 kHz.
constexpr int kPart = 1600;

/// (channel, N).
py::array_t<float> process(PythonAuralizer& auralizer,
                           const std::map<std::uint64_t, Array<float>>& signals, int samples) {
    std::vector<SourceSignal> inputs;
    for (const auto& [number, signal] : signals) inputs.push_back({{number}, signal.data()});
    const std::size_t channels = auralizer->output_channels();
    const auto count = static_cast<std::size_t>(samples);
    py::array_t<float> array(std::vector<std::size_t>{channels, count});
    std::vector<float*> outputs;
    for (std::size_t c = 0; c < channels; ++c) outputs.push_back(array.mutable_data() + c * count);
    Interruption interruption;
    {
        const py::gil_scoped_release released;
        for (int done = 0; done < samples && interruption.continues(); done += kPart) {
            const int part = std::min(kPart, samples - done);
            auralizer.render(inputs, outputs, part);
            for (SourceSignal& input : inputs) input.samples += part;
            for (float*& output : outputs) output += part;
        }
    }
    interruption.rethrow();
    return array;
}

/// (channel, N); empty before the first frame of the source.
py::array_t<float> impulse_response(PythonAuralizer& auralizer, std::uint64_t source) {
    std::vector<std::vector<float>> response;
    {
        const py::gil_scoped_release released;
        response = auralizer->impulse_response({source});
    }
    const std::size_t samples = response.empty() ? 0 : response[0].size();
    py::array_t<float> array(std::vector<std::size_t>{auralizer->output_channels(), samples});
    for (std::size_t c = 0; c < response.size(); ++c)
        std::copy(response[c].begin(), response[c].end(), array.mutable_data() + c * samples);
    return array;
}

/// A transform of the first three rows of a matrix (4, 4).
RigidTransform transform_of(const Array<float>& rows) {
    RigidTransform transform;
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column)
            transform.rotation[column][row] = *rows.data(row, column);
        transform.translation[row] = *rows.data(row, 3);
    }
    return transform;
}

}  // namespace

void bind_auralizer(py::module_& module) {
    using Released = py::call_guard<py::gil_scoped_release>;
    py::class_<PythonAuralizer, Holder>(module, "Auralizer")
        .def(py::init(&make_auralizer))
        .def("add_source", &add_source)
        .def(
            "remove_source",
            [](PythonAuralizer& a, std::uint64_t source) { a->remove_source({source}); },
            Released())
        .def("set_source",
             [](PythonAuralizer& a, std::uint64_t source, const Array<float>& values) {
                 const Pose pose = pose_of(values.data());
                 const py::gil_scoped_release released;
                 a->set_source({source}, pose);
             })
        .def(
            "set_gain",
            [](PythonAuralizer& a, std::uint64_t source, float gain_db) {
                a->set_gain({source}, gain_db);
            },
            Released())
        .def("set_listener",
             [](PythonAuralizer& a, const Array<float>& values) {
                 const Pose pose = pose_of(values.data());
                 const py::gil_scoped_release released;
                 a->set_listener(pose);
             })
        .def("set_transform",
             [](PythonAuralizer& a, const ObjectKey& object, const Array<float>& rows) {
                 const RigidTransform transform = transform_of(rows);
                 const py::gil_scoped_release released;
                 std::visit([&](const auto& key) { a->set_transform(key, transform); }, object);
             })
        .def(
            "set_material",
            [](PythonAuralizer& a, const ObjectKey& object, const Material& material) {
                std::visit([&](const auto& key) { a->set_material(key, material); }, object);
            },
            Released())
        .def("set_scene",
             [](PythonAuralizer& a, const SharedScene& shared) {
                 const Scene scene = with(*shared.get(), a.overrides());
                 const py::gil_scoped_release released;
                 a->set_scene(scene);
                 static_cast<void>(a->status());  // of a propagation that has failed meanwhile
             })
        .def(
            "silent", [](PythonAuralizer& a, std::uint64_t source) { return a->silent({source}); },
            Released())
        .def("process", &process)
        .def("impulse_response", &impulse_response)
        .def_property_readonly("frames",
                               [](PythonAuralizer& a) {
                                   const py::gil_scoped_release released;
                                   return a->status().frames;
                               })
        .def_property_readonly("tail_samples", [](PythonAuralizer& a) { return a->tail_samples(); })
        .def_property_readonly("latency_samples",
                               [](PythonAuralizer& a) { return a->latency_samples(); });
}

}  // namespace aula
