#include <sys/resource.h>

#include "engine/scene/directivity_hdf5.h"
#include "engine/scene/directivity_measurements.h"
#include "tests/fuzz/directivity_target.h"

using namespace aula;

namespace {

/// Sets how many files can be open; returns the number before.
rlim_t limit_files(rlim_t number) {
    rlimit limits{};
    getrlimit(RLIMIT_NOFILE, &limits);
    const rlim_t before = limits.rlim_cur;
    limits.rlim_cur = number;
    setrlimit(RLIMIT_NOFILE, &limits);
    return before;
}

}  // namespace

/// The input is a SOFA file. The program that reads it in a child process runs in this one, as does
/// what uses its answer.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const rlim_t files = limit_files(0);
    limit_files(files);
    const auto file = test::input_file("set.sofa", data, size);
    const DirectivityAnswer answer =
        read_hdf5_directivity(file.c_str(), [] { limit_files(0); });
    limit_files(files);
    const DirectivityHeader& header = answer.header;
    if (header.verdict != DirectivityHeader::Verdict::usable) return 0;
    test::expect(answer.coordinates.size() == std::size_t{3} * header.directions &&
                     answer.frequencies_hz.size() == header.frequencies &&
                     answer.energies.size() == std::size_t{header.directions} * header.frequencies,
                 "an answer has the sizes of its header");
    return test::make_any_directivity([&] { return directivity_of(answer); });
}
