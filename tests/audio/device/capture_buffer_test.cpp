#include "audio/device/capture_buffer.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

using namespace aula;

namespace {

constexpr double kRate_hz = 48000;
constexpr int kBlock = 256;
constexpr double kStep_rad = 2 * std::numbers::pi / 96;  // 500 Hz

/// Writes a sine in portions of any size to a buffer and reads it in blocks.
class Line {
 public:
    void write(std::size_t count) {
        std::vector<float> samples(count);
        for (float& sample : samples)
            sample = 0.5F * static_cast<float>(std::sin(kStep_rad * static_cast<double>(time_++)));
        buffer_.write(samples);
    }
    void read(std::size_t blocks = 1) {
        std::vector<float> block(kBlock);
        for (; blocks > 0; --blocks) {
            buffer_.read(block);
            heard_.insert(heard_.end(), block.begin(), block.end());
        }
    }
    /// The largest difference of adjacent samples. That of the sine is 0.5 * kStep_rad = 0.033.
    float largest_step() const {
        float largest = 0;
        for (std::size_t i = 1; i < heard_.size(); ++i)
            largest = std::max(largest, std::abs(heard_[i] - heard_[i - 1]));
        return largest;
    }
    const std::vector<float>& heard() const { return heard_; }
    CaptureBuffer& buffer() { return buffer_; }

 private:
    CaptureBuffer buffer_{kRate_hz, kBlock};
    std::vector<float> heard_;
    long time_ = 0;
};

// A crossfade of two sines over a block, or a fade of 5 ms, adds at most 1/240 per sample.
constexpr float kSmooth = 0.034F + 1.0F / 240;

}  // namespace

TEST_CASE("A steady input is output unchanged, delayed by a block") {
    Line line;
    line.write(kBlock);
    for (int i = 0; i < 1000; ++i) {
        line.write(kBlock);
        line.read();
    }
    CHECK(line.buffer().reserve() == kBlock);
    // Exact after the fade.
    for (std::size_t i = 1000; i < line.heard().size(); ++i)
        REQUIRE(line.heard()[i] ==
                0.5F * static_cast<float>(std::sin(kStep_rad * static_cast<double>(i))));
}

TEST_CASE("An input that stops fades out to silence and returns without a click") {
    Line line;
    line.write(2 * kBlock + 100);
    line.read(20);
    CHECK(std::all_of(line.heard().end() - kBlock, line.heard().end(),
                      [](float sample) { return sample == 0; }));
    CHECK(line.buffer().reserve() == 2 * kBlock);
    line.write(10 * kBlock);
    line.read(5);
    CHECK(std::abs(*std::max_element(line.heard().end() - kBlock, line.heard().end())) > 0.49F);
    CHECK(line.largest_step() < kSmooth);
}

TEST_CASE("An input in bursts causes underruns only at first") {
    Line line;
    std::size_t silent_blocks = 0;
    for (int burst = 0; burst < 200; ++burst) {
        line.write(4 * kBlock);
        for (int i = 0; i < 4; ++i) {
            line.read();
            const bool silent = std::all_of(line.heard().end() - kBlock, line.heard().end(),
                                            [](float sample) { return sample == 0; });
            if (burst >= 20 && silent) ++silent_blocks;
        }
    }
    CHECK(silent_blocks == 0);
    CHECK(line.largest_step() < kSmooth);
}

TEST_CASE(
    "Surplus of an input faster than the output is dropped smoothly, without a growing delay") {
    Line line;
    line.write(kBlock);
    // Faster by 0.1 %: 48 samples per second, 2880 per minute.
    for (int i = 0; i < 60 * 48000 / kBlock; ++i) {
        line.write(kBlock + (i % 4 == 0 ? 1 : 0));
        line.read();
    }
    CHECK(line.largest_step() < kSmooth);
    // The buffer contains only a few blocks of the surplus of 2880 samples.
    std::size_t left = 0;
    std::vector<float> block(kBlock);
    do {
        line.buffer().read(block);
        ++left;
    } while (block.back() != 0);
    CHECK(left < 7);
}

TEST_CASE("An input slower than the output fades at underruns without a click") {
    Line line;
    line.write(kBlock);
    for (int i = 0; i < 60 * 48000 / kBlock; ++i) {
        line.write(kBlock - (i % 4 == 0 ? 1 : 0));
        line.read();
    }
    CHECK(line.largest_step() < kSmooth);
    const auto silent = std::count(line.heard().begin(), line.heard().end(), 0.0F);
    CHECK(silent < 48000);  // less than 1 s of 60 s
}

TEST_CASE("The reserve is at most 0.2 s for any number of interruptions") {
    Line line;
    for (int stop = 0; stop < 100; ++stop) {
        line.write(line.buffer().reserve() + kBlock);
        line.read(line.buffer().reserve() / kBlock + 3);
    }
    constexpr std::size_t kMost = 9600;
    CHECK(line.buffer().reserve() > kMost - kBlock);
    CHECK(line.buffer().reserve() <= kMost);
}

TEST_CASE("Dropping surplus input keeps the reserve, which compensates a late block") {
    Line line;
    line.write(21 * kBlock);
    // After a second of steady input the surplus is dropped.
    for (int i = 0; i < 2 * 48000 / kBlock; ++i) {
        line.read();
        line.write(kBlock);
    }
    line.read(2);
    line.write(2 * kBlock);
    line.read(1);
    CHECK(line.buffer().reserve() == kBlock);  // it would have grown at an underrun
    CHECK(line.largest_step() < kSmooth);
    // The buffer contains the reserve and the block written since.
    std::vector<float> block(kBlock);
    std::size_t left = 0;
    do {
        line.buffer().read(block);
        ++left;
    } while (block.back() != 0);
    CHECK(left <= 3);
}
