#pragma once

#include <array>
#include <cstddef>
#include <string>

#include "aula/measurement.h"

namespace aula {

/// A parameter as documents describe it.
struct ParameterText {
    std::string symbol;     ///< such as "T30"
    std::string name;       ///< such as "reverberation time T30"
    std::string unit;       ///< "s", "dB" or ""
    std::string single;     ///< of what octaves the single number is, such as "mean of 500 and ..."
    int decimals = 2;       ///< of values
    double noticeable = 0;  ///< just noticeable difference in the unit, or a share of the value
    bool is_share = false;  ///< `noticeable` is a share of the value
};

/// The index of the speech transmission index: after those of AcousticParameter.
inline constexpr std::size_t kSpeechTransmission = kAcousticParameterCount;

/// Number of parameters with the speech transmission index.
inline constexpr std::size_t kDescribedParameterCount = kAcousticParameterCount + 1;

/// The text of a parameter, by its index. The just noticeable differences are those of ISO 3382-1,
/// annex A; for STI that of Bradley, Reich and Norcross 1999.
ParameterText parameter_text(std::size_t parameter);

/// The single number of a parameter, by its index.
const MeasuredValue& single_number(const PairParameters& parameters, std::size_t parameter);

}  // namespace aula
