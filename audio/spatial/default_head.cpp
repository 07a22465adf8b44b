#include "audio/spatial/default_head.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>

#include "process/embedded_file.h"

namespace aula {
std::span<const std::byte> embedded_kemar();
}  // namespace aula

// The responses of the left ear, 512 samples of two bytes each, the lower one first: by elevations
// from the lowest, then by azimuths from the front to the left. The file make_kemar.py wrote it.
AULA_EMBEDDED_FILE(embedded_kemar, AULA_KEMAR)

namespace aula {

namespace {

constexpr std::size_t kSamples = 512;
constexpr double kDistance_m = 1.4;

/// A ring of equal elevation and its number of azimuths, at equal steps from the front.
struct Ring {
    int elevation_deg;
    int azimuths;
};

constexpr Ring kRings[]{{-40, 56}, {-30, 60}, {-20, 72}, {-10, 72}, {0, 72},  {10, 72}, {20, 72},
                        {30, 60},  {40, 56},  {50, 45},  {60, 36},  {70, 24}, {80, 12}, {90, 1}};

}  // namespace

HeadMeasurements default_head() {
    HeadMeasurements head;
    head.file = "the default head responses";
    head.sample_rate_hz = 44100;
    head.samples = kSamples;
    const std::span<const std::byte> bytes = embedded_kemar();
    const auto add_response = [&](int index) {
        for (std::size_t n = 0; n < kSamples; ++n) {
            const std::size_t at = 2 * (static_cast<std::size_t>(index) * kSamples + n);
            const auto low = std::to_integer<std::uint16_t>(bytes[at]);
            const auto high = std::to_integer<std::uint16_t>(bytes[at + 1]);
            const auto value = static_cast<std::int16_t>(low | high << 8);
            head.responses.push_back(static_cast<float>(value) / 32768);
        }
    };
    int first = 0;
    for (const auto& [elevation_deg, azimuths] : kRings) {
        const double elevation_rad = elevation_deg * std::numbers::pi / 180;
        const double across_m = kDistance_m * std::cos(elevation_rad);
        for (int i = 0; i < azimuths; ++i) {
            // Signed, so that both sides mirror each other bit by bit.
            const double azimuth_rad =
                2 * std::numbers::pi * (2 * i > azimuths ? i - azimuths : i) / azimuths;
            head.positions.push_back({static_cast<float>(across_m * std::cos(azimuth_rad)),
                                      static_cast<float>(across_m * std::sin(azimuth_rad)),
                                      static_cast<float>(kDistance_m * std::sin(elevation_rad))});
            // The right ear is the mirror image of the left one.
            add_response(first + i);
            add_response(first + (azimuths - i) % azimuths);
        }
        first += azimuths;
    }
    head.delays_samples.resize(2 * head.positions.size());
    return head;
}

}  // namespace aula
