#include "audio/spatial/sofa_file.h"

#include <string>

#include "audio/spatial/embedded_sofa_reader.h"
#include "audio/spatial/sofa_stream.h"
#include "aula/exception.h"
#include "process/contained_process.h"

namespace aula {

HeadMeasurements read_sofa(const std::filesystem::path& file) {
    constexpr const char* kExpected =
        "a SOFA file of head-related impulse responses (SimpleFreeFieldHRIR)";
    const auto fail = [&](const char* why) {
        throw InputError(file.string() + ": " + why + "; expected " + kExpected);
    };
    ContainedProcess reader(embedded_sofa_reader(), file, kExpected);
    SofaHeader header;
    if (!reader.read(header) || header.magic != SofaHeader::kMagic)
        fail("is damaged and cannot be read as SOFA");
    using Verdict = SofaHeader::Verdict;
    const std::size_t directions = header.directions;
    const std::size_t samples = header.samples;
    switch (header.verdict) {
        case Verdict::usable:
            break;
        case Verdict::other_kind:
            fail("does not hold the responses of two ears for at least four directions");
            break;
        case Verdict::incomplete:
            fail("has fewer values than its sizes say");
            break;
        case Verdict::too_large:
            fail(
                "has more than 65536 directions, or responses of more than 32768 or, together, "
                "33554432 samples");
            break;
        default:
            fail("cannot be read as SOFA");
    }
    if (directions > kMaxDirections || samples > kLongestResponse_samples ||
        2 * directions * samples > kMaxResponseSamples)
        fail("is damaged and cannot be read as SOFA");
    HeadMeasurements measurements;
    measurements.file = file;
    measurements.sample_rate_hz = header.sample_rate_hz;
    measurements.samples = samples;
    measurements.positions.resize(directions);
    measurements.responses.resize(2 * directions * samples);
    measurements.delays_samples.resize(2 * directions);
    if (!reader.read(measurements.positions) || !reader.read(measurements.responses) ||
        !reader.read(measurements.delays_samples))
        fail("is damaged and cannot be read as SOFA");
    return measurements;
}

}  // namespace aula
