// A program that reads a SOFA file from standard input and writes a SofaHeader and the measurements
// to standard output. It is embedded in the library and run by read_sofa().

#include <mysofa.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "audio/spatial/sofa_file.h"
#include "audio/spatial/sofa_stream.h"
#include "process/contained_program.h"

namespace {

using namespace aula;
using Verdict = SofaHeader::Verdict;

struct CloseSofa {
    void operator()(MYSOFA_HRTF* sofa) const { mysofa_free(sofa); }
};

bool answer(Verdict verdict) {
    SofaHeader header;
    header.verdict = verdict;
    return write(header);
}

/// True for HDF5 without the marks of netCDF's dimensions. libmysofa reads only the structures of
/// HDF5 that netCDF uses.
bool is_plain_hdf5(std::span<const std::byte> file) {
    const std::string_view bytes(reinterpret_cast<const char*>(file.data()), file.size());
    if (!bytes.starts_with("\x89HDF\r\n\x1a\n")) return false;
    for (const std::string_view name : {"_Netcdf4", "netCDF dimension"}) {
        if (std::search(bytes.begin(), bytes.end(), name.begin(), name.end()) != bytes.end())
            return false;
    }
    return true;
}

bool run(std::span<const std::byte> file) {
    int error = MYSOFA_OK;
    const std::unique_ptr<MYSOFA_HRTF, CloseSofa> sofa(
        mysofa_load_data(reinterpret_cast<const char*>(file.data()), file.size(), &error));
    if (!sofa || error != MYSOFA_OK)
        return answer(is_plain_hdf5(file) ? Verdict::not_netcdf : Verdict::unreadable);
    if (mysofa_check(sofa.get()) != MYSOFA_OK) return answer(Verdict::other_kind);
    const std::size_t directions = sofa->M;
    const std::size_t samples = sofa->N;
    if (sofa->R != 2 || sofa->C != 3) return answer(Verdict::other_kind);
    if (directions > kMaxDirections || samples > kLongestResponse_samples ||
        2 * directions * samples > kMaxResponseSamples)
        return answer(Verdict::too_large);
    const auto has = [](const MYSOFA_ARRAY& array, std::size_t elements) {
        return array.values != nullptr && array.elements >= elements;
    };
    if (!has(sofa->DataSamplingRate, 1) || !has(sofa->SourcePosition, 3 * directions) ||
        !has(sofa->DataIR, 2 * directions * samples))
        return answer(Verdict::incomplete);
    // Delays are given per ear, or per direction and ear. Missing delays are 0.
    std::vector<float> delays(2 * directions);
    const MYSOFA_ARRAY& given = sofa->DataDelay;
    if (given.values != nullptr && given.elements != 0) {
        if (given.elements != 2 && given.elements != delays.size())
            return answer(Verdict::incomplete);
        for (std::size_t i = 0; i < delays.size(); ++i)
            delays[i] = given.values[given.elements == 2 ? i % 2 : i];
    }
    mysofa_tocartesian(sofa.get());

    SofaHeader header;
    header.verdict = Verdict::usable;
    header.directions = static_cast<std::uint32_t>(directions);
    header.samples = static_cast<std::uint32_t>(samples);
    header.sample_rate_hz = sofa->DataSamplingRate.values[0];
    return write(header) &&
           write_bytes(sofa->SourcePosition.values, 3 * directions * sizeof(float)) &&
           write_bytes(sofa->DataIR.values, 2 * directions * samples * sizeof(float)) &&
           write(delays);
}

}  // namespace

int main() { std::_Exit(run(contain()) ? 0 : 1); }
