#include "audio/spatial/sofa_file.h"

#include "audio/spatial/embedded_sofa_reader.h"
#include "audio/spatial/sofa_stream.h"
#include "process/contained_process.h"

namespace aula {

HeadMeasurements read_sofa(const std::filesystem::path& file) {
    constexpr const char* kDamaged = "is damaged and cannot be read as SOFA";
    ContainedProcess reader(embedded_sofa_reader(), file,
                            "a SOFA file of head-related impulse responses (SimpleFreeFieldHRIR)");
    SofaHeader header;
    reader.read(header);
    if (header.magic != SofaHeader::kMagic) reader.refuse(kDamaged);
    using Verdict = SofaHeader::Verdict;
    const std::size_t directions = header.directions;
    const std::size_t samples = header.samples;
    switch (header.verdict) {
        case Verdict::usable:
            break;
        case Verdict::not_netcdf:
            reader.refuse(
                "is HDF5 but not netCDF-4, as h5py writes it, and cannot be read; the Python "
                "package sofar converts it: sofar.write_sofa(\"new.sofa\", "
                "sofar.read_sofa(\"old.sofa\"))");
            break;
        case Verdict::other_kind:
            reader.refuse("does not hold the responses of two ears for at least four directions");
            break;
        case Verdict::incomplete:
            reader.refuse("has fewer values than its sizes say");
            break;
        case Verdict::too_large:
            reader.refuse(
                "has more than 65536 directions, or responses of more than 32768 or, together, "
                "33554432 samples");
            break;
        default:
            reader.refuse("cannot be read as SOFA");
    }
    if (directions > kMaxDirections || samples > kLongestResponse_samples ||
        2 * directions * samples > kMaxResponseSamples)
        reader.refuse(kDamaged);
    HeadMeasurements measurements;
    measurements.file = file;
    measurements.sample_rate_hz = header.sample_rate_hz;
    measurements.samples = samples;
    measurements.positions.resize(directions);
    measurements.responses.resize(2 * directions * samples);
    measurements.delays_samples.resize(2 * directions);
    reader.read(measurements.positions);
    reader.read(measurements.responses);
    reader.read(measurements.delays_samples);
    return measurements;
}

}  // namespace aula
