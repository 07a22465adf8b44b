#include "apps/documents/parameter_text.h"

#include "apps/room/offline/measurement_text.h"

namespace aula {

namespace {

constexpr const char* kMiddle = "mean of 500 and 1000 Hz";
constexpr const char* kLateral = "mean of 125 to 1000 Hz";
constexpr const char* kInteraural = "mean of 500 to 2000 Hz";

struct Description {
    const char* name;
    const char* single;
    double noticeable;
    bool is_share = false;
};

/// [parameter]
constexpr std::array<Description, kDescribedParameterCount> kDescriptions{{
    {"reverberation time T20", kMiddle, 0.05, true},
    {"reverberation time T30", kMiddle, 0.05, true},
    {"early decay time EDT", kMiddle, 0.05, true},
    {"clarity C50", kMiddle, 1},
    {"clarity C80", kMiddle, 1},
    {"definition D50", kMiddle, 0.05},
    {"centre time Ts", kMiddle, 0.01},
    {"strength G", kMiddle, 1},
    {"early lateral energy fraction J_LF", kLateral, 0.05},
    {"early lateral energy fraction J_LFC", kLateral, 0.05},
    {"late lateral level L_J", "mean energy of 125 to 1000 Hz", 1},
    {"early interaural cross-correlation IACC_E", kInteraural, 0.075},
    {"late interaural cross-correlation IACC_L", kInteraural, 0.075},
    {"speech transmission index STI", "all octaves, male speech", 0.03},
}};

}  // namespace

ParameterText parameter_text(std::size_t parameter) {
    const Description& description = kDescriptions[parameter];
    ParameterText text{.symbol = "STI",
                       .name = description.name,
                       .unit = {},
                       .single = description.single,
                       .noticeable = description.noticeable,
                       .is_share = description.is_share};
    if (parameter == kSpeechTransmission) return text;
    const auto acoustic = static_cast<AcousticParameter>(parameter);
    text.symbol = acoustic_parameter_name(acoustic);
    text.unit = acoustic_parameter_unit(acoustic);
    text.decimals = parameter_decimals(acoustic);
    return text;
}

const MeasuredValue& single_number(const PairParameters& parameters, std::size_t parameter) {
    return parameter == kSpeechTransmission ? parameters.sti : parameters.broadband[parameter];
}

}  // namespace aula
