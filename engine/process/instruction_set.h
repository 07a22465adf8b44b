#pragma once

#include <cstdint>

namespace aula {

/// The instruction sets that hot functions are compiled for, each a superset of those before.
enum class InstructionSet : std::uint8_t {
    kPortable,  ///< what the compiler assumes of every processor
    kAvx2,      ///< x86-64 with AVX2, BMI, BMI2, F16C, FMA and POPCNT
    kAvx512,    ///< kAvx2 and AVX-512 BW, CD, DQ, F and VL
};

/// The largest one that the processor and the system support. Static initialisers of other sources
/// may see kPortable.
extern const InstructionSet kBestInstructionSet;

}  // namespace aula
