#include "apps/room/offline/acoustic_parameters.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <span>

#include "engine/response/lateral_energy.h"
#include "engine/response/speech_transmission.h"

namespace aula {

namespace {

/// The octaves whose mean is the single number.
struct Octaves {
    std::size_t first;
    std::size_t end;
};
constexpr Octaves kMiddle{3, 5};   // 500 and 1000 Hz
constexpr Octaves kLateral{1, 5};  // 125 to 1000 Hz
enum class Averaging { values, energies };

struct Description {
    std::string_view name;
    std::string_view unit;
    std::optional<double> BandParameters::*value = nullptr;
    std::optional<double> LateralParameters::*lateral = nullptr;
    Octaves octaves = kMiddle;
    Averaging averaging = Averaging::values;
};

constexpr std::array<Description, kAcousticParameterCount> kDescriptions{{
    {"T20", "s", &BandParameters::t20_s},
    {"T30", "s", &BandParameters::t30_s},
    {"EDT", "s", &BandParameters::edt_s},
    {"C50", "dB", &BandParameters::c50_db},
    {"C80", "dB", &BandParameters::c80_db},
    {"D50", "", &BandParameters::d50},
    {"Ts", "s", &BandParameters::ts_s},
    {"G", "dB", &BandParameters::g_db},
    {"J_LF", "", nullptr, &LateralParameters::jlf, kLateral},
    {"J_LFC", "", nullptr, &LateralParameters::jlfc, kLateral},
    {"L_J", "dB", nullptr, &LateralParameters::lj_db, kLateral, Averaging::energies},
    {"IACC_E", ""},  // see interaural.h
    {"IACC_L", ""},
}};

constexpr std::size_t kOctaveValues = kAcousticParameterCount * kBandCount;
constexpr std::size_t kSti = kOctaveValues + kAcousticParameterCount;

const Description& describe(AcousticParameter parameter) {
    return kDescriptions[static_cast<std::size_t>(parameter)];
}

/// The single number of a parameter; empty if an octave does not have it.
std::optional<double> single_number(const Description& description,
                                    std::span<const std::optional<double>> bands) {
    const auto [first, end] = description.octaves;
    const bool of_energies = description.averaging == Averaging::energies;
    double sum = 0;
    for (const std::optional<double>& value : bands.subspan(first, end - first)) {
        if (!value) return std::nullopt;
        sum += of_energies ? std::pow(10, *value / 10) : *value;
    }
    const double mean = sum / static_cast<double>(end - first);
    return of_energies ? 10 * std::log10(mean) : mean;
}

/// All values: [parameter * kBandCount + band], then the single numbers, then STI, then third
/// octaves.
MeasuredValues values_of(const RoomParameters& bands,
                         const std::array<LateralParameters, kBandCount>& lateral,
                         const std::optional<double>& sti) {
    MeasuredValues values;
    values.reserve(kSti + 1);
    for (const Description& description : kDescriptions) {
        for (std::size_t b = 0; b < kBandCount; ++b) {
            // Lateral energies need the whole response, as the strength does.
            std::optional<double>& value = values.emplace_back();
            if (description.value) value = bands[b].*description.value;
            if (description.lateral && bands[b].g_db) value = lateral[b].*description.lateral;
        }
    }
    for (std::size_t p = 0; p < kAcousticParameterCount; ++p)
        values.push_back(
            single_number(kDescriptions[p], std::span(values).subspan(p * kBandCount, kBandCount)));
    values.push_back(sti);
    return values;
}

/// Adds the values in third octaves: [parameter * kThirdOctaveCount + third octave].
void add_third_octaves(const ThirdOctaveParameters& thirds, MeasuredValues& values) {
    for (std::size_t p = 0; p < kThirdOctaveParameterCount; ++p)
        for (const BandParameters& third : thirds) values.push_back(third.*kDescriptions[p].value);
}

MeasuredValues values_of(const EnergyResponse& response, const ParameterContext& context) {
    const RoomParameters bands = room_parameters(response);
    bool is_complete = true;
    for (std::size_t b = 0; b < kBandCount; ++b) is_complete &= b == 0 || bands[b].g_db;
    MeasuredValues values = values_of(
        bands, lateral_parameters(response, context.lateral_axis),
        is_complete
            ? speech_transmission_index(response, context.speech.speech_db, context.speech.noise_db)
            : std::nullopt);
    if (context.third_octaves)
        add_third_octaves(third_octave_parameters(response, *context.third_octaves), values);
    return values;
}

/// The values and errors in the order of values_of().
PairParameters sorted(const MeasuredValues& values, const MeasuredValues& errors) {
    PairParameters parameters;
    for (std::size_t p = 0; p < kAcousticParameterCount; ++p) {
        for (std::size_t band = 0; band < kBandCount; ++band)
            parameters.octaves[p][band] = {values[p * kBandCount + band],
                                           errors[p * kBandCount + band]};
        parameters.broadband[p] = {values[kOctaveValues + p], errors[kOctaveValues + p]};
    }
    parameters.sti = {values[kSti], errors[kSti]};
    constexpr std::size_t kFirst = kSti + 1;
    for (std::size_t i = kFirst; i < values.size(); ++i) {
        const std::size_t third = (i - kFirst) % kThirdOctaveCount;
        if (third == 0) parameters.third_octaves.emplace_back();
        parameters.third_octaves.back()[third] = {values[i], errors[i]};
    }
    return parameters;
}

}  // namespace

std::string_view acoustic_parameter_name(AcousticParameter parameter) {
    return describe(parameter).name;
}

std::string_view acoustic_parameter_unit(AcousticParameter parameter) {
    return describe(parameter).unit;
}

Vec3 lateral_axis(const Pose& receiver, const Vec3& source) {
    constexpr float kAbove = 1e-3F;  // of the distance
    const Vec3 to_source = source - receiver.position;
    const Vec3 left(-to_source.y, to_source.x, 0);
    const float horizontal_m = glm::length(left);
    if (horizontal_m > kAbove * glm::length(to_source)) return left / horizontal_m;
    return receiver.rotation()[1];
}

SpeechConditions with_power_of(SpeechConditions speech, const Directivity& directivity) {
    const Bands on_axis_db = directivity.on_axis_db();
    for (std::size_t b = 0; b < kBandCount; ++b)
        if (std::isfinite(on_axis_db[b])) speech.speech_db[b] -= on_axis_db[b];
    return speech;
}

PairParameters acoustic_parameters(const RoomParameters& bands, const std::optional<double>& sti) {
    const MeasuredValues values = values_of(bands, {}, sti);
    return sorted(values, MeasuredValues(values.size()));
}

PairParameters acoustic_parameters(const EnergyResponse& response,
                                   const ParameterContext& context) {
    const MeasuredValues values = values_of(response, context);
    return sorted(values, MeasuredValues(values.size()));
}

PairParameters acoustic_parameters(const WindowedMean& mean, const ParameterContext& context) {
    if (mean.windows() < 2) return acoustic_parameters(mean.mean(), context);
    const auto of_response = [&](const EnergyResponse& response) {
        return values_of(response, context);
    };
    return sorted(of_response(mean.mean()), mean.standard_errors(of_response));
}

}  // namespace aula
