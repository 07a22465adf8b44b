#include <mysofa.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <vector>

#include "audio/dsp/resample.h"
#include "audio/spatial/hrtf.h"
#include "tests/audio/convolution/signals.h"
#include "tests/audio/player.h"

namespace sofa_set_test {

using namespace aula;
using namespace aula::test;

// Rendered direct sound compared with the SOFA file, read independently of read_sofa(). Hrtf
// removes the common transfer function of all directions, so only ratios of ears and of directions
// are compared.

namespace {

constexpr const char* kFile = "/usr/share/libmysofa/default.sofa";
constexpr std::size_t kSamples = 16384;
constexpr std::array<double, 6> kOctaves_hz{250, 500, 1000, 2000, 4000, 8000};

using Direction = std::array<float, 3>;

// Bands narrow enough that the common transfer function is constant within each and cancels.
constexpr std::size_t kBands = 12;
/// Mean level in dB of the narrow bands of an octave, [ear][octave].
using Levels = std::array<std::array<double, kOctaves_hz.size()>, 2>;

double db(double ratio) { return 10 * std::log10(ratio); }

Levels levels_of(const Signals& ears) {
    Levels levels{};
    for (std::size_t e = 0; e < 2; ++e) {
        for (std::size_t b = 0; b < kOctaves_hz.size(); ++b) {
            for (std::size_t i = 0; i < kBands; ++i) {
                const double low_hz =
                    kOctaves_hz[b] * std::exp2(static_cast<double>(i) / kBands - 0.5);
                levels[e][b] +=
                    db(band_energy(ears[e], low_hz, low_hz * std::exp2(1.0 / kBands), kRate_hz)) /
                    kBands;
            }
        }
    }
    return levels;
}

/// The measured responses nearest to a direction.
class Sofa {
 public:
    Sofa() : sofa_(mysofa_load(kFile, &error_)) {
        REQUIRE(sofa_ != nullptr);
        mysofa_tocartesian(sofa_);
    }
    ~Sofa() { mysofa_free(sofa_); }
    Sofa(const Sofa&) = delete;
    Sofa& operator=(const Sofa&) = delete;

    Signals ears(const Direction& direction) const {
        std::size_t best = 0;
        double nearest = 1e9;
        for (std::size_t i = 0; i < sofa_->M; ++i) {
            const float* const p = sofa_->SourcePosition.values + 3 * i;
            const double length =
                std::sqrt(double{p[0]} * double{p[0]} + double{p[1]} * double{p[1]} +
                          double{p[2]} * double{p[2]});
            double distance = 0;
            for (std::size_t c = 0; c < 3; ++c) {
                distance += std::pow(double{p[c]} / length - double{direction[c]}, 2);
            }
            if (distance < nearest) {
                nearest = distance;
                best = i;
            }
        }
        REQUIRE(nearest < 1e-6);
        Signals ears;
        for (std::size_t e = 0; e < 2; ++e) {
            const float* const ir = sofa_->DataIR.values + (2 * best + e) * sofa_->N;
            Signal padded(64 + sofa_->N + 64);
            std::copy_n(ir, sofa_->N, padded.begin() + 64);
            Signal ear = resample(padded, 1, double{sofa_->DataSamplingRate.values[0]}, kRate_hz);
            ear.resize(kSamples);
            ears.push_back(std::move(ear));
        }
        return ears;
    }

 private:
    int error_ = 0;
    MYSOFA_HRTF* sofa_;
};

/// Impulse responses of both ears to direct sound, rendered.
Signals rendered(const Direction& direction) {
    static const auto hrtf = std::make_shared<const Hrtf>("", kRate_hz);
    Signal impulse(kSamples);
    impulse[0] = 1;
    Player player(config_for(OutputFormat::binaural), hrtf, {impulse});
    SourceSound sound;
    sound.direct = path_of(480, 1, direction);
    player.publish({sound});
    player.play_until(kSamples);
    return player.outputs();
}

const Direction kFront{1, 0, 0};
const Direction kBack{-1, 0, 0};
const Direction kLeft{0, 1, 0};
const Direction kRight{0, -1, 0};
const Direction kUp{0, 0, 1};
/// In front, elevation 30 degrees.
const Direction kFrontHigh{std::sqrt(0.75F), 0, 0.5F};

}  // namespace

TEST_CASE("Rendered level differences of the ears agree with the SOFA file") {
    const Sofa sofa;
    for (const Direction& direction : {kLeft, kRight, kFront, kBack, kUp, kFrontHigh}) {
        const Levels set = levels_of(sofa.ears(direction));
        const Levels levels = levels_of(rendered(direction));
        for (std::size_t b = 0; b < kOctaves_hz.size(); ++b) {
            CAPTURE(direction[0], direction[1], direction[2], kOctaves_hz[b]);
            // Minimum phase preserves magnitudes; only the length of the filters differs.
            CHECK(levels[0][b] - levels[1][b] == Approx(set[0][b] - set[1][b]).margin(0.25));
        }
    }
    const Levels left = levels_of(rendered(kLeft));
    const Levels right = levels_of(rendered(kRight));
    const Levels set_left = levels_of(sofa.ears(kLeft));
    const Levels set_right = levels_of(sofa.ears(kRight));
    for (std::size_t b = 0; b < kOctaves_hz.size(); ++b) {
        // The asymmetry of the measured and of the rendered responses.
        const double set_db = set_left[0][b] - set_right[1][b];
        const double rendered_db = left[0][b] - right[1][b];
        CAPTURE(kOctaves_hz[b], set_db, rendered_db);
        CHECK(rendered_db == Approx(set_db).margin(0.1));
    }
}

TEST_CASE("Rendered level differences of directions agree with the SOFA file") {
    const Sofa sofa;
    const Levels set_front = levels_of(sofa.ears(kFront));
    const Levels front = levels_of(rendered(kFront));
    double largest_db = 0;
    for (const Direction& direction : {kBack, kUp, kFrontHigh, kLeft}) {
        const Levels set = levels_of(sofa.ears(direction));
        const Levels levels = levels_of(rendered(direction));
        for (std::size_t b = 0; b < kOctaves_hz.size(); ++b) {
            const double set_db = set[0][b] - set_front[0][b];
            const double rendered_db = levels[0][b] - front[0][b];
            CAPTURE(direction[0], direction[1], direction[2], kOctaves_hz[b]);
            CHECK(rendered_db == Approx(set_db).margin(0.5));
            largest_db = std::max(largest_db, std::abs(set_db));
        }
    }
    // Companion: the directions differ by more than the tolerance.
    CHECK(largest_db > 6);
}

}  // namespace sofa_set_test
