#include <pybind11/stl.h>

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "apps/output/printable.h"
#include "apps/python/arrays.h"
#include "apps/python/scene_bindings.h"
#include "apps/room/offline/analysis_text.h"
#include "aula/engine/third_octaves.h"

namespace aula {

namespace {

/// Values by the name of a parameter, (response, band) or (response,).
using Arrays = std::map<std::string, py::array_t<double>>;

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

py::array_t<double> table_of(const std::vector<double>& values, std::size_t bands) {
    const auto rows = static_cast<py::ssize_t>(values.size() / bands);
    py::array_t<double> array({rows, static_cast<py::ssize_t>(bands)});
    std::copy(values.begin(), values.end(), array.mutable_data());
    return array;
}

/// The values of responses in their bands; NaN for a silent one, which is empty.
Arrays band_values(const std::vector<std::optional<ResponseAnalysis>>& responses,
                   bool third_octaves) {
    const std::size_t bands = third_octaves ? kThirdOctaveCount : kBandCount;
    const auto array = [&](const auto& of) {
        std::vector<double> values;
        for (const auto& response : responses)
            for (std::size_t band = 0; band < bands; ++band)
                values.push_back(response ? of(*response, band).value_or(kUnknown) : kUnknown);
        return table_of(values, bands);
    };
    Arrays arrays;
    for (std::size_t p = 0; p < kAnalysedParameterCount; ++p) {
        const std::string name(acoustic_parameter_name(static_cast<AcousticParameter>(p)));
        arrays[name] = array([&](const ResponseAnalysis& a, std::size_t band) {
            return third_octaves ? analysed_value(a.third_octaves[band], p)
                                 : a.parameters.octaves[p][band].value;
        });
    }
    arrays["range_db"] = array([&](const ResponseAnalysis& a, std::size_t band) {
        return third_octaves ? a.third_octaves[band].range_db : a.range_db[band];
    });
    return arrays;
}

Arrays single_numbers(const std::vector<std::optional<ResponseAnalysis>>& responses) {
    const auto array = [&](const auto& of) {
        std::vector<double> values;
        for (const auto& response : responses)
            values.push_back(response ? of(response->parameters).value_or(kUnknown) : kUnknown);
        return table_of(values, 1);
    };
    Arrays arrays;
    for (std::size_t p = 0; p < kAnalysedParameterCount; ++p)
        arrays[std::string(acoustic_parameter_name(static_cast<AcousticParameter>(p))) + "_mean"] =
            array([&](const PairParameters& of) { return of.broadband[p].value; });
    arrays["STI"] = array([](const PairParameters& of) { return of.sti.value; });
    return arrays;
}

/// Analyses responses (response, sample), or the channels of a file if its name is not empty.
/// Returns bands, single numbers and warnings.
std::tuple<Arrays, Arrays, std::vector<std::string>> analysed(
    const Array<float>& samples, const std::string& file, double sample_rate_hz, bool third_octaves,
    const std::optional<Array<float>>& speech_db, const std::optional<Array<float>>& noise_db) {
    AnalysisOptions options{.third_octaves = third_octaves, .speech = {}};
    if (speech_db) {
        options.speech.emplace();
        options.speech->speech_db = speech_db->size() == 1
                                        ? SpeechConditions::male_speech_db(*speech_db->data())
                                        : bands_of(*speech_db);
        if (noise_db) options.speech->noise_db = bands_of(*noise_db);
    }
    std::vector<std::optional<ResponseAnalysis>> responses;
    {
        const py::gil_scoped_release released;
        if (!file.empty()) {
            responses = analyse_file(file, options);
        } else {
            const auto count = static_cast<std::size_t>(samples.shape(1));
            for (py::ssize_t i = 0; i < samples.shape(0); ++i) {
                const std::span<const float> one(samples.data() + i * samples.shape(1), count);
                const bool silent =
                    std::all_of(one.begin(), one.end(), [](float x) { return x == 0; });
                responses.push_back(
                    silent ? std::nullopt
                           : std::optional(analyse_response("response " + std::to_string(i), one,
                                                            sample_rate_hz, options)));
            }
        }
    }
    std::vector<std::string> warnings;
    for (const auto& response : responses)
        if (response)
            for (const std::string& line : response->warnings)
                warnings.push_back(printable_line(line));
    return {band_values(responses, third_octaves), single_numbers(responses), warnings};
}

}  // namespace

void bind_analysis(py::module_& module) { module.def("analyse", &analysed); }

}  // namespace aula
