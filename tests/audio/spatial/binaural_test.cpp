#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <vector>

#include "audio/render/renderer.h"
#include "audio/spatial/head_responses.h"
#include "audio/spatial/hrtf.h"
#include "aula/exception.h"
#include "tests/audio/convolution/signals.h"
#include "tests/support/temporary_folder.h"

namespace binaural_test {

using namespace aula;
using namespace aula::test;

namespace {

constexpr double kRate_hz = 48000;

/// The default head responses, read once: it takes a second.
std::shared_ptr<const Hrtf> kemar() {
    static const auto hrtf = std::make_shared<const Hrtf>("", kRate_hz);
    return hrtf;
}

/// The responses of both ears to a unit impulse with the given sound.
Signals ears_of(const SourceSound& sound, const HeadRotation& head = kNoRotation) {
    RendererConfig config;
    config.response_samples = 4800;
    RenderFrameBuilder builder(config, kemar());
    Renderer renderer(config, kemar());
    std::unique_ptr<RenderFrame> frame = builder.make_frame();
    builder.prepare(std::span(&sound, 1), *frame);
    renderer.mailbox().publish(std::move(frame));
    Signal input(4096);
    input[0] = 1;
    Signals ears(2, Signal(4096));
    for (std::size_t n = 0; n < 4096; n += 256) {
        const std::array<const float*, 1> in{input.data() + n};
        const std::array<float*, 2> out{ears[0].data() + n, ears[1].data() + n};
        renderer.render(in, head, out, 256);
    }
    return ears;
}

DiscretePath path_from(std::array<float, 3> direction) {
    DiscretePath path;
    path.delay_s = 480 / kRate_hz;
    path.direction = direction;
    path.band_gain.fill(1);
    return path;
}

SourceSound direct_from(std::array<float, 3> direction) {
    SourceSound sound;
    sound.direct = path_from(direction);
    return sound;
}

SourceSound early_from(std::array<float, 3> direction) {
    SourceSound sound;
    sound.early = {path_from(direction)};
    return sound;
}

double level_difference_db(const Signals& ears, double from_hz, double to_hz) {
    return 10 * std::log10(band_energy(ears[0], from_hz, to_hz, kRate_hz) /
                           band_energy(ears[1], from_hz, to_hz, kRate_hz));
}

/// Delay of the right ear re the left one, from the peak of the cross-correlation.
double time_difference_s(const Signals& ears) {
    double best = -1;
    int lag_of_best = 0;
    for (int lag = -60; lag <= 60; ++lag) {
        double sum = 0;
        for (int n = 100; n < 3900; ++n) {
            sum += double{ears[0][static_cast<std::size_t>(n)]} *
                   double{ears[1][static_cast<std::size_t>(n + lag)]};
        }
        if (sum > best) {
            best = sum;
            lag_of_best = lag;
        }
    }
    return lag_of_best / kRate_hz;
}

/// Centre of gravity of the energy of both ears, samples.
double middle_sample(const Signals& ears) {
    double total = 0;
    double moment = 0;
    for (const Signal& ear : ears) {
        for (std::size_t n = 0; n < ear.size(); ++n) {
            const double energy = double{ear[n]} * double{ear[n]};
            total += energy;
            moment += energy * static_cast<double>(n);
        }
    }
    return moment / total;
}

}  // namespace

TEST_CASE("A lateral source is louder and earlier at the nearer ear") {
    const Signals left = ears_of(direct_from({0, 1, 0}));
    const Signals right = ears_of(direct_from({0, -1, 0}));
    CHECK(level_difference_db(left, 4000, 16000) > 10);
    CHECK(level_difference_db(right, 4000, 16000) < -10);
    CHECK(time_difference_s(left) > 0.6e-3);
    CHECK(time_difference_s(left) < 0.8e-3);
    CHECK(time_difference_s(right) == Approx(-time_difference_s(left)).margin(1.1 / kRate_hz));
    // The measured head is symmetric within 0.1 dB.
    for (const double from_hz : {500.0, 2000.0, 8000.0}) {
        CHECK(level_difference_db(left, from_hz, 2 * from_hz) ==
              Approx(-level_difference_db(right, from_hz, 2 * from_hz)).margin(0.1));
    }
}

TEST_CASE("Sources in front and behind are equal at both ears but differ from each other") {
    const Signals front = ears_of(direct_from({1, 0, 0}));
    const Signals back = ears_of(direct_from({-1, 0, 0}));
    CHECK(level_difference_db(front, 500, 8000) == Approx(0).margin(0.1));
    CHECK(level_difference_db(back, 500, 8000) == Approx(0).margin(0.1));
    CHECK(time_difference_s(front) == 0);
    double difference_db = 0;
    for (const double from_hz : {2000.0, 4000.0, 8000.0}) {
        difference_db = std::max(
            difference_db,
            std::abs(10 * std::log10(band_energy(front[0], from_hz, 2 * from_hz, kRate_hz) /
                                     band_energy(back[0], from_hz, 2 * from_hz, kRate_hz))));
    }
    CHECK(difference_db > 3);
}

TEST_CASE("A turn of the head moves the source to the other side") {
    const HeadRotation looking_left{{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}};
    // The source is at the right of a head that looks left.
    for (const SourceSound& sound : {direct_from({1, 0, 0}), early_from({1, 0, 0})}) {
        CHECK(level_difference_db(ears_of(sound, looking_left), 2000, 8000) < -3);
    }
}

TEST_CASE("Reflections are rendered with the direction and delay of direct sound") {
    const Signals direct = ears_of(direct_from({0, 1, 0}));
    const Signals early = ears_of(early_from({0, 1, 0}));
    CHECK(level_difference_db(early, 4000, 16000) > 10);
    CHECK(level_difference_db(ears_of(early_from({0, -1, 0})), 4000, 16000) < -10);
    CHECK(level_difference_db(ears_of(early_from({1, 0, 0})), 500, 8000) == Approx(0).margin(0.1));
    // The decoder adds no delay beyond that of the centre of the head: within 20 samples, 0.4 ms.
    CHECK(middle_sample(early) == Approx(middle_sample(direct)).margin(20));
    CHECK(middle_sample(direct) > 480);
}

TEST_CASE("Reverberation within the lead of the decoder is delayed, not lost") {
    const auto ears_after = [](std::size_t delay) {
        Signal response(100);
        response[delay] = 1;
        SourceSound sound;
        const Signal silent(100);
        sound.ambisonics.fill(silent);
        sound.ambisonics[0] = response;
        return ears_of(sound);
    };
    // The lead is 1 ms, 48 samples: sound 10 samples after the emission is rendered like sound 58
    // samples after it.
    const Signals soon = ears_after(10);
    const Signals later = ears_after(58);
    for (std::size_t e = 0; e < 2; ++e) {
        CHECK(*std::max_element(later[e].begin(), later[e].end()) > 0.1F);
        for (std::size_t n = 0; n < later[e].size(); ++n) {
            // Rounding.
            if (std::abs(soon[e][n] - later[e][n]) > 1e-6F) FAIL("ear " << e << ", sample " << n);
        }
    }
    // Companion: later sound is not delayed.
    CHECK(ears_after(59)[0] != later[0]);
}

TEST_CASE("A diffuse field has a level of 0 dB in every octave, averaged over any directions") {
    const std::shared_ptr<const Hrtf> hrtf = kemar();
    constexpr std::size_t kDirections = 400;
    for (double centre_hz = 125; centre_hz < 20000; centre_hz *= 2) {
        const double from_hz = centre_hz / std::numbers::sqrt2;
        const double to_hz = centre_hz * std::numbers::sqrt2;
        std::array<double, 2> direct{};
        Signal padded(8192);
        const auto energy_of = [&](const std::vector<float>& response) {
            std::fill(std::copy(response.begin(), response.end(), padded.begin()), padded.end(),
                      0.0F);
            return band_energy(padded, from_hz, to_hz, kRate_hz);
        };
        padded[0] = 1;
        const double impulse_energy = band_energy(padded, from_hz, to_hz, kRate_hz);
        for (std::size_t i = 0; i < kDirections; ++i) {
            const double z = 1 - (2 * static_cast<double>(i) + 1) / kDirections;
            const double azimuth = 2.39996323 * static_cast<double>(i);
            const double radius = std::sqrt(1 - z * z);
            const auto ears =
                hrtf->ears({static_cast<float>(radius * std::cos(azimuth)),
                            static_cast<float>(radius * std::sin(azimuth)), static_cast<float>(z)});
            for (std::size_t e = 0; e < 2; ++e) {
                direct[e] += energy_of(ears[e].minimum_phase) / kDirections / impulse_energy;
            }
        }
        for (std::size_t e = 0; e < 2; ++e) {
            CAPTURE(centre_hz, e, direct[e]);
            const double direct_db = 10 * std::log10(direct[e]);
            // Above 11 kHz the equalisation is bounded.
            CHECK(direct_db == Approx(0).margin(centre_hz < 10000 ? 0.3 : 2));
        }
    }
}

TEST_CASE("Interpolated directions are as loud as the measured ones") {
    const std::shared_ptr<const Hrtf> hrtf = kemar();
    // The horizontal plane is measured every 5 degrees.
    const auto level_db = [&](double azimuth_deg) {
        const double azimuth = azimuth_deg * std::numbers::pi / 180;
        Signal response = hrtf->ears({static_cast<float>(std::cos(azimuth)),
                                      static_cast<float>(std::sin(azimuth)), 0})[0]
                              .minimum_phase;
        response.resize(4096);
        return 10 * std::log10(band_energy(response, 12000, 16000, kRate_hz));
    };
    for (const double azimuth_deg : {0.0, 30.0, 60.0, 90.0}) {
        const double between = level_db(azimuth_deg + 2.5);
        const double mean = 0.5 * (level_db(azimuth_deg) + level_db(azimuth_deg + 5));
        CAPTURE(azimuth_deg);
        CHECK(between == Approx(mean).margin(1.5));
    }
}

TEST_CASE("Delays are relative to the earliest ear, and the largest is that of a spherical head") {
    double earliest_s = 1;
    double latest_s = 0;
    for (const auto& ears : kemar()->responses().ears) {
        for (const Hrtf::Ear& ear : ears) {
            earliest_s = std::min(earliest_s, ear.delay_s);
            latest_s = std::max(latest_s, ear.delay_s);
        }
    }
    CHECK(earliest_s == 0);
    // The far ear of a sphere of radius 8.75 cm: (1 + pi / 2) radii, Woodworth 1938.
    CHECK(latest_s == Approx((1 + std::numbers::pi / 2) * 0.0875 / 343.2).epsilon(0.1));
}

TEST_CASE("The interaural time difference increases steadily from the front to the side") {
    constexpr int kSteps = 9;  // of 5 degrees, the measured directions
    std::vector<double> difference_s;
    for (int k = -kSteps; k <= kSteps; ++k) {
        const double azimuth = k * std::numbers::pi / 36;
        const auto ears = kemar()->ears(
            {static_cast<float>(std::cos(azimuth)), static_cast<float>(std::sin(azimuth)), 0});
        difference_s.push_back(ears[1].delay_s - ears[0].delay_s);
    }
    // Woodworth's a / c (x + sin x) has second differences of at most 1.4 us. The rest is the error
    // of the measurement, a tenth of a sample of 21 us.
    for (std::size_t k = 1; k + 1 < difference_s.size(); ++k) {
        CAPTURE(k, difference_s[k]);
        CHECK(std::abs(difference_s[k - 1] - 2 * difference_s[k] + difference_s[k + 1]) < 3.5e-6);
        CHECK(difference_s[k + 1] - difference_s[k] == Approx(39e-6).margin(5e-6));
    }
}

TEST_CASE("Delays stated in a SOFA file are added to those of its responses") {
    const test::TemporaryFolder folder;
    const std::filesystem::path file = folder.path() / "delayed.sofa";
    std::filesystem::copy_file("/usr/share/libmysofa/default.sofa", file);
    // The last bytes of the file are Data.Delay, deflated: two zeros.
    const std::array<unsigned char, 11> zeros{0x78, 0x01, 0x63, 0x60, 0x40, 0x05,
                                              0x00, 0x00, 0x10, 0x00, 0x01};
    // 0 and 2 samples, deflated.
    const std::array<unsigned char, 11> delays{0x78, 0x01, 0x63, 0x40, 0x05, 0x0e,
                                               0x00, 0x00, 0x50, 0x00, 0x41};
    const Hrtf plain(file, kRate_hz);
    std::fstream bytes(file, std::ios::in | std::ios::out | std::ios::binary);
    std::array<unsigned char, 11> last{};
    bytes.seekg(-11, std::ios::end);
    bytes.read(reinterpret_cast<char*>(last.data()), 11);
    REQUIRE(last == zeros);
    bytes.seekp(-11, std::ios::end);
    bytes.write(reinterpret_cast<const char*>(delays.data()), 11);
    bytes.close();
    const Hrtf delayed(file, kRate_hz);
    const auto& ears = plain.responses().ears;
    const auto& later = delayed.responses().ears;
    REQUIRE(later.size() == ears.size());
    // One per ear, in samples of the file, for all directions.
    for (std::size_t i = 0; i < ears.size(); ++i) {
        const double right_s = later[i][1].delay_s - ears[i][1].delay_s;
        const double left_s = later[i][0].delay_s - ears[i][0].delay_s;
        REQUIRE(right_s - left_s == Approx(2 / 44100.0).epsilon(1e-9));  // rounding
    }
}

TEST_CASE("A file that is not SOFA is refused in one line") {
    const std::filesystem::path text =
        std::filesystem::temp_directory_path() / "aula-test-not-sofa.sofa";
    std::ofstream(text) << "no SOFA file";
    for (const std::filesystem::path& file : {text, std::filesystem::path("/no/such/file.sofa")}) {
        std::string message;
        try {
            Hrtf(file, kRate_hz);
        } catch (const InputError& error) {
            message = error.what();
        }
        CHECK(message.starts_with(file.string() + ": "));
        CHECK(message.find("expected a SOFA file") != std::string::npos);
        CHECK(message.find('\n') == std::string::npos);
    }
    std::filesystem::remove(text);
}

}  // namespace binaural_test
