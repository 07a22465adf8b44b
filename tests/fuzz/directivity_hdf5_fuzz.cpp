#include <span>

#include "engine/scene/directivity_hdf5.h"
#include "engine/scene/directivity_measurements.h"
#include "tests/fuzz/directivity_target.h"

using namespace aula;

/// The input is a SOFA file. The program that reads it in a child process runs in this one, as does
/// what uses its answer.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const DirectivityAnswer answer = read_hdf5_directivity(std::as_bytes(std::span(data, size)));
    const DirectivityHeader& header = answer.header;
    if (header.verdict != DirectivityHeader::Verdict::usable) return 0;
    test::expect(answer.coordinates.size() == std::size_t{3} * header.directions &&
                     answer.frequencies_hz.size() == header.frequencies &&
                     answer.energies.size() == std::size_t{header.directions} * header.frequencies,
                 "an answer has the sizes of its header");
    return test::make_any_directivity([&] { return directivity_of(answer); });
}
