#include <cstring>

#include "audio/spatial/sofa_file.h"
#include "tests/fuzz/hrtf_target.h"

using namespace aula;

namespace {

/// Reads values from the input; zeros follow its end.
class Values {
 public:
    Values(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}

    std::uint8_t byte() {
        std::uint8_t x = 0;
        take(&x, 1);
        return x;
    }
    /// Any bit pattern, or a small number, so that inputs pass the checks.
    float number(bool any) {
        float x = 0;
        if (!any) return static_cast<float>(byte()) / 16 - 8;
        take(&x, sizeof(x));
        return x;
    }

 private:
    void take(void* to, std::size_t count) {
        count = std::min(count, size_);
        std::memcpy(to, data_, count);
        data_ += count;
        size_ -= count;
    }

    const std::uint8_t* data_;
    std::size_t size_;
};

}  // namespace

/// The input contains the measurements of a SOFA file.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    Values values(data, size);
    const std::uint8_t any = values.byte();
    HeadMeasurements measured;
    measured.file = "set.sofa";
    constexpr std::array kRates_hz{8000.0F, 44100.0F, 48000.0F, 768000.0F};
    measured.sample_rate_hz = (any & 1) != 0 ? values.number(true) : kRates_hz[(any >> 1) & 3];
    measured.samples = values.byte() % 64;
    measured.positions.resize(values.byte() % 16);
    for (auto& position : measured.positions)
        for (float& x : position) x = values.number((any & 8) != 0);
    measured.responses.resize(2 * measured.positions.size() * measured.samples);
    for (float& x : measured.responses) x = values.number((any & 16) != 0);
    measured.delays_samples.resize(2 * measured.positions.size());
    for (float& x : measured.delays_samples) x = values.number((any & 32) != 0);
    return test::make_any_hrtf(measured);
}
