#include "apps/session/offline/acoustic_parameters.h"

namespace aula {

namespace {

struct Description {
    std::string_view name;
    std::string_view unit;
    std::optional<double> BandParameters::*value;
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
}};

const Description& describe(AcousticParameter parameter) {
    return kDescriptions[static_cast<std::size_t>(parameter)];
}

}  // namespace

std::string_view acoustic_parameter_name(AcousticParameter parameter) {
    return describe(parameter).name;
}

std::string_view acoustic_parameter_unit(AcousticParameter parameter) {
    return describe(parameter).unit;
}

MeasuredValues acoustic_parameters(const EnergyResponse& response) {
    const RoomParameters bands = room_parameters(response);
    MeasuredValues values;
    values.reserve(kDescriptions.size() * bands.size());
    for (const Description& description : kDescriptions)
        for (const BandParameters& band : bands) values.push_back(band.*description.value);
    return values;
}

PairParameters acoustic_parameters(const WindowedMean& mean) {
    const auto of_response = [](const EnergyResponse& response) {
        return acoustic_parameters(response);
    };
    const MeasuredValues values = of_response(mean.mean());
    const MeasuredValues errors =
        mean.windows() > 1 ? mean.standard_errors(of_response) : MeasuredValues(values.size());
    PairParameters parameters;
    for (std::size_t p = 0; p < kAcousticParameterCount; ++p)
        for (std::size_t band = 0; band < kBandCount; ++band)
            parameters.octaves[p][band] = {values[p * kBandCount + band],
                                           errors[p * kBandCount + band]};
    return parameters;
}

}  // namespace aula
