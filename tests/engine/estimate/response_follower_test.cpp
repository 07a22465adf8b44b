#include "engine/estimate/response_follower.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "tests/support/statistics.h"

using namespace aula;

namespace {

const TimeBins kBins(0.5);
constexpr int kFrames = ResponseFollower::kMostFrames;

/// A response with this energy in each bin of each band, and noise: independent normal factors of
/// the bins.
class NoisyResponse {
 public:
    EnergyResponse draw(double energy, double relative_noise) {
        EnergyResponse response = EnergyResponse::silent(kBins);
        for (std::size_t k = 0; k < kBins.count(); ++k) {
            const double e = energy * std::max(0.0, 1 + relative_noise * normal_(random_));
            response.energy[k] = Bands::filled(static_cast<float>(e));
            response.directions[k] = DirectionMoments::of(Vec3(1, 0, 0)) * response.energy[k].sum();
        }
        return response;
    }

 private:
    std::mt19937_64 random_{test::test_seed()};
    std::normal_distribution<double> normal_;
};

const std::size_t kLate = kBins.index(0.032);

/// Rms of the late bins' relative errors.
double error(const EnergyResponse& response, double energy) {
    double squares = 0;
    for (std::size_t k = kLate; k < kBins.count(); ++k)
        squares += std::pow(double{response.energy[k][3]} / energy - 1, 2);
    return std::sqrt(squares / static_cast<double>(kBins.count() - kLate));
}

double mean_energy(const EnergyResponse& response) {
    double sum = 0;
    for (std::size_t k = kLate; k < kBins.count(); ++k) sum += double{response.energy[k][3]};
    return sum / static_cast<double>(kBins.count() - kLate);
}

/// 100 estimates of an unchanging response.
ResponseFollower followed(NoisyResponse& noisy, double energy, double moved_m) {
    ResponseFollower follower(EnergyResponse::silent(kBins), kFrames);
    for (int frame = 0; frame < 100; ++frame) follower.follow(noisy.draw(energy, 0.1), 1, moved_m);
    return follower;
}

}  // namespace

TEST_CASE("Noise of an unchanging response is averaged over frames, late bins only") {
    NoisyResponse noisy;
    ResponseFollower follower = followed(noisy, 2, 0.05);
    std::vector<double> means;
    double squares = 0;
    constexpr int kTimes = 64;
    for (int frame = 0; frame < kTimes; ++frame) {
        const EnergyResponse newest = noisy.draw(2, 0.1);
        follower.follow(newest, 1, 0.05);
        const EnergyResponse& response = follower.response();
        for (std::size_t k = 0; k < kLate; ++k) {
            REQUIRE(response.energy[k][3] == newest.energy[k][3]);
            REQUIRE(response.directions[k] == newest.directions[k]);
        }
        REQUIRE(response.directions[kLate].intensity.x == Approx(response.energy[kLate].sum()));
        REQUIRE(response.directions[kLate].yy == Approx(-response.energy[kLate].sum() / 3));
        squares += std::pow(error(response, 2), 2) / kTimes;
        means.push_back(mean_energy(response));
    }
    // With the least share 1 / 16, the variance of a mean is 1 / 31 of the estimate's. The tracking
    // signal of noise raises the share and may take half of that gain.
    const double noise = std::sqrt(squares);
    CHECK(noise < 0.1 / 2.5);
    CHECK(noise > 0.1 / std::sqrt(31));
    // Companion: every estimate alone.
    CHECK(error(noisy.draw(2, 0.1), 2) > 0.08);
    // Consecutive means share most estimates: 16 of them count as one.
    const test::Estimate all = test::estimate(means);
    CHECK(std::abs(all.mean - 2) < test::kFamilyZ * 4 * all.standard_error);
}

TEST_CASE("A response follows a change of level within a few frames") {
    // A level that doubles or halves, and one that grows by a tenth in each frame.
    NoisyResponse noisy;
    for (const double level : {4.0, 1.0}) {
        ResponseFollower follower = followed(noisy, 2, 0.05);
        for (int frame = 0; frame < 6; ++frame) follower.follow(noisy.draw(level, 0.1), 1, 0.05);
        CAPTURE(level);
        CHECK(mean_energy(follower.response()) == Approx(level).epsilon(0.05));
        // Companion: the mean over 16 estimates would not have arrived.
        CHECK(std::abs(2 + (level - 2) * (1 - std::pow(15.0 / 16, 6)) - level) > 0.05 * level);
    }
    ResponseFollower follower = followed(noisy, 2, 0.05);
    double level = 2;
    for (int frame = 0; frame < 30; ++frame)
        follower.follow(noisy.draw(level *= 1.1, 0.1), 1, 0.05);
    CHECK(mean_energy(follower.response()) == Approx(level).epsilon(0.05));
}

TEST_CASE("A slow change is followed with less lag than that of the smoothing") {
    NoisyResponse noisy;
    const double moved_m = 0.005;
    ResponseFollower moving = followed(noisy, 2, moved_m);
    ResponseFollower resting = followed(noisy, 2, 0);  // without correction
    double level = 2;
    double moving_lag = 0;
    double resting_lag = 0;
    constexpr int kWalk = 400;
    for (int frame = 0; frame < kWalk; ++frame) {
        const EnergyResponse estimate = noisy.draw(level *= 1.002, 0.2);
        moving.follow(estimate, 1, moved_m);
        resting.follow(estimate, 1, 0);
        moving_lag += (1 - mean_energy(moving.response()) / level) / kWalk;
        resting_lag += (1 - mean_energy(resting.response()) / level) / kWalk;
    }
    CAPTURE(moving_lag, resting_lag);
    CHECK(resting_lag > 0.005);
    CHECK(std::abs(moving_lag) < 0.6 * resting_lag);
}

TEST_CASE("Noise that all bins have in common is averaged, and a common change is followed") {
    // The estimates have a common factor with a standard deviation of 5 %. The first and the last
    // groups are silent, or none.
    NoisyResponse noisy;
    std::mt19937_64 random(test::test_seed() + 1);
    std::normal_distribution<double> normal;
    constexpr int kWalk = 2700;
    constexpr int kMeasured = 2500;
    struct Followed {
        double deviation = 0;
        double lag = 0;
    };
    const auto followed = [&](double growth, std::size_t silent) {
        ResponseFollower follower(EnergyResponse::silent(kBins), kFrames);
        const std::size_t middle = kBins.count() / 2;
        double level = 2e-8;
        double sum = 0;
        double squares = 0;
        for (int frame = 0; frame < kWalk; ++frame) {
            level *= growth;
            EnergyResponse estimate = noisy.draw(level * (1 + 0.05 * normal(random)), 0.1);
            for (std::size_t k = 0; k < silent; ++k) {
                estimate.energy[kLate + k] = {};
                estimate.energy[kBins.count() - 1 - k] = {};
            }
            follower.follow(estimate, 1, 0.05);
            if (silent > 0) REQUIRE(follower.response().energy[kLate].sum() == 0);
            if (frame < kWalk - kMeasured) continue;
            double mean = 0;
            for (std::size_t k = middle - 20; k < middle + 20; ++k)
                mean += double{follower.response().energy[k][3]} / 40;
            sum += (mean / level - 1) / kMeasured;
            squares += std::pow(mean / level - 1, 2) / kMeasured;
        }
        return Followed{std::sqrt(squares - sum * sum), -sum};
    };
    for (const std::size_t silent : {std::size_t{0}, std::size_t{20}}) {
        const Followed constant = followed(1, silent);
        CAPTURE(silent, constant.deviation, constant.lag);
        CHECK(constant.deviation < 0.05 / 2);
        CHECK(std::abs(constant.lag) < 0.01);
        // 2 % in a frame: a mean over the last 2 N - 1 frames would be about a quarter behind, and
        // groups that are followed one by one have 3 % of noise.
        const Followed growing = followed(1.02, silent);
        CAPTURE(growing.deviation, growing.lag);
        CHECK(growing.deviation < 0.0278);
        CHECK(std::abs(growing.lag) < 0.01);
    }
}

TEST_CASE("Sparse estimates keep their mean while the ends move") {
    // One bin in 25 holds something: the mean is 1, and most estimates of a group are below it.
    std::mt19937_64 random(test::test_seed());
    std::uniform_real_distribution<double> uniform;
    double sum = 0;
    constexpr int kFollowers = 20;
    constexpr int kWalk = 400;
    for (int n = 0; n < kFollowers; ++n) {
        ResponseFollower follower(EnergyResponse::silent(kBins), kFrames);
        for (int frame = 0; frame < kWalk; ++frame) {
            EnergyResponse estimate = EnergyResponse::silent(kBins);
            for (auto& energy : estimate.energy)
                if (uniform(random) < 0.04) energy = Bands::filled(25);
            follower.follow(estimate, 1, 0.05);
            if (frame >= 100)
                sum += mean_energy(follower.response()) / (kFollowers * (kWalk - 100));
        }
    }
    CHECK(sum == Approx(1).epsilon(0.1));
}

TEST_CASE("A change before a silence has no effect after it") {
    // The level falls by 10 % in each frame, then nothing is heard, then the old level.
    NoisyResponse noisy;
    std::mt19937_64 random(test::test_seed() + 2);
    std::normal_distribution<double> normal;
    double worst_db = 0;
    for (int n = 0; n < 12; ++n) {
        ResponseFollower follower = followed(noisy, 2, 0.005);
        const auto follow = [&](double level) {
            const double common = 1 + 0.05 * normal(random);
            follower.follow(noisy.draw(level * common, 0.1), 1, 0.005);
        };
        for (int frame = 0; frame < 20; ++frame) follow(2 * std::pow(0.9, frame));
        for (int frame = 0; frame < 20; ++frame)
            follower.follow(EnergyResponse::silent(kBins), 1, 0.005);
        for (int frame = 0; frame < 60; ++frame) {
            follow(2);
            if (frame <= 16) continue;
            const double level_db = 10 * std::log10(mean_energy(follower.response()) / 2);
            worst_db = std::max(worst_db, std::abs(level_db));
        }
    }
    // Four standard deviations of the noise; a slope from before the silence gives 1.4 dB.
    CHECK(worst_db < 0.7);
}

TEST_CASE("A change of any single bin is a change of its group") {
    // All energy of a group is in one bin; the first group has 16 of 1 ms.
    for (std::size_t bin = kLate; bin < kLate + 16; ++bin) {
        ResponseFollower follower(EnergyResponse::silent(kBins), kFrames);
        const auto follow = [&](float energy) {
            EnergyResponse estimate = EnergyResponse::silent(kBins);
            estimate.energy[bin] = Bands::filled(energy);
            follower.follow(estimate, 1, 0.005);
        };
        for (int frame = 0; frame < 50; ++frame) follow(2);
        for (int frame = 0; frame < 6; ++frame) follow(4);
        CAPTURE(bin);
        // With the least share it would have come to 2.64.
        CHECK(follower.response().energy[bin][0] > 3.9F);
    }
}

TEST_CASE("Bins that moving ends cross in a frame have the newest estimate") {
    // Ends that move by a bin of 4 ms in a frame: only wider bins are smoothed.
    NoisyResponse noisy;
    const double moved_m = 0.004 * 343.2;
    ResponseFollower follower = followed(noisy, 2, moved_m);
    const EnergyResponse newest = noisy.draw(2, 0.1);
    follower.follow(newest, 1, moved_m);
    for (std::size_t k = 0; k < kBins.count(); ++k) {
        CAPTURE(k);
        // Rounding of the bin's width.
        if (kBins.begin_s(k) < 0.256) {
            CHECK(follower.response().energy[k][3] == Approx(newest.energy[k][3]).epsilon(1e-4));
        } else {
            CHECK(follower.response().energy[k][3] != Approx(newest.energy[k][3]).epsilon(1e-4));
        }
    }
}

TEST_CASE("A follower without other frames has the mean, and one with them comes to it") {
    NoisyResponse noisy;
    ResponseFollower cold(EnergyResponse::silent(kBins), kFrames);
    cold.follow(noisy.draw(3, 0.1), 1, 0);
    const EnergyResponse mean = noisy.draw(2, 0);
    cold.follow(mean, 2, 0);
    CHECK(error(cold.response(), 2) == 0);

    ResponseFollower warm = followed(noisy, 3, 0.05);
    warm.follow(noisy.draw(3, 0.1), 1, 0);
    double before = error(warm.response(), 2);
    CHECK(before > 0.3);
    for (int frames = 2; frames < kFrames; ++frames) {
        warm.follow(mean, frames, 0);
        const double now = error(warm.response(), 2);
        CHECK((now < before || now == 0));
        before = now;
    }
    warm.follow(mean, kFrames, 0);
    CHECK(error(warm.response(), 2) == 0);
    CHECK(warm.response().energy[0] == mean.energy[0]);
}

TEST_CASE("A window of one frame smooths nothing") {
    NoisyResponse noisy;
    ResponseFollower follower(EnergyResponse::silent(kBins), 1);
    for (int frame = 0; frame < 20; ++frame) {
        const EnergyResponse newest = noisy.draw(2, 0.1);
        follower.follow(newest, 1, 0.05);
        REQUIRE(follower.response().energy == newest.energy);
    }
}

TEST_CASE("After a restart earlier estimates have no effect") {
    NoisyResponse noisy;
    ResponseFollower follower = followed(noisy, 200, 0.05);
    follower.restart();
    NoisyResponse same;
    NoisyResponse again;
    ResponseFollower fresh(EnergyResponse::silent(kBins), kFrames);
    for (int frame = 0; frame < 20; ++frame) {
        follower.follow(same.draw(2, 0.1), 1, 0.05);
        fresh.follow(again.draw(2, 0.1), 1, 0.05);
        REQUIRE(follower.response().energy == fresh.response().energy);
        REQUIRE(follower.response().directions == fresh.response().directions);
    }
}

TEST_CASE("Silence and sound after it are followed without a division by zero") {
    ResponseFollower follower(EnergyResponse::silent(kBins), kFrames);
    NoisyResponse noisy;
    for (int frame = 0; frame < 5; ++frame) follower.follow(EnergyResponse::silent(kBins), 1, 0.05);
    follower.follow(noisy.draw(2, 0), 1, 0.05);
    CHECK(error(follower.response(), 2) < 0.01);
    for (int frame = 0; frame < 20; ++frame)
        follower.follow(EnergyResponse::silent(kBins), 1, 0.05);
    CHECK(mean_energy(follower.response()) < 0.01);
}
