#include "audio/device/capture_buffer.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
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
            output_.insert(output_.end(), block.begin(), block.end());
        }
    }
    /// The largest difference of adjacent samples. That of the sine is 0.5 * kStep_rad = 0.033.
    float largest_step() const {
        float largest = 0;
        for (std::size_t i = 1; i < output_.size(); ++i)
            largest = std::max(largest, std::abs(output_[i] - output_[i - 1]));
        return largest;
    }
    /// Whether the last block of the output is silent.
    bool ends_silent() const {
        return std::all_of(output_.end() - kBlock, output_.end(),
                           [](float sample) { return sample == 0; });
    }
    /// Number of blocks that can be read up to the first one that ends in silence.
    std::size_t drain() {
        std::vector<float> block(kBlock);
        std::size_t count = 0;
        do {
            buffer_.read(block);
            ++count;
        } while (block.back() != 0);
        return count;
    }
    const std::vector<float>& output() const { return output_; }
    CaptureBuffer& buffer() { return buffer_; }

 private:
    CaptureBuffer buffer_{kRate_hz, kBlock};
    std::vector<float> output_;
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
    for (std::size_t i = 1000; i < line.output().size(); ++i)
        REQUIRE(line.output()[i] ==
                0.5F * static_cast<float>(std::sin(kStep_rad * static_cast<double>(i))));
}

TEST_CASE("An input that stops fades out to silence and returns without a click") {
    Line line;
    line.write(2 * kBlock + 100);
    line.read(20);
    CHECK(line.ends_silent());
    CHECK(line.buffer().reserve() == 2 * kBlock);
    line.write(10 * kBlock);
    line.read(5);
    CHECK(std::abs(*std::max_element(line.output().end() - kBlock, line.output().end())) > 0.49F);
    CHECK(line.largest_step() < kSmooth);
}

TEST_CASE("An input in bursts causes underruns only at first") {
    Line line;
    std::size_t silent_blocks = 0;
    for (int burst = 0; burst < 200; ++burst) {
        line.write(4 * kBlock);
        for (int i = 0; i < 4; ++i) {
            line.read();
            if (burst >= 20 && line.ends_silent()) ++silent_blocks;
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
    CHECK(line.drain() < 7);
}

TEST_CASE("An input slower than the output fades at underruns without a click") {
    Line line;
    line.write(kBlock);
    for (int i = 0; i < 60 * 48000 / kBlock; ++i) {
        line.write(kBlock - (i % 4 == 0 ? 1 : 0));
        line.read();
    }
    CHECK(line.largest_step() < kSmooth);
    const auto silent = std::count(line.output().begin(), line.output().end(), 0.0F);
    CHECK(silent < 48000);  // less than 1 s of 60 s
}

TEST_CASE("The reserve is at most 0.2 s for any number of interruptions") {
    Line line;
    for (int stop = 0; stop < 100; ++stop) {
        line.write(line.buffer().reserve() + kBlock);
        line.read(line.buffer().reserve() / kBlock + 3);
    }
    constexpr std::size_t kMax = 9600;
    CHECK(line.buffer().reserve() > kMax - kBlock);
    CHECK(line.buffer().reserve() <= kMax);
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
    CHECK(line.drain() <= 3);
}

TEST_CASE("Clock drift of either sign keeps the delay within a few blocks for minutes") {
    const int block = GENERATE(64, 480, 2048);
    const double drift = GENERATE(-1e-3, -1e-4, 1e-4, 1e-3);
    CaptureBuffer buffer(kRate_hz, block);
    // The value of a sample is its time: the output tells its delay, and never goes back.
    std::vector<float> samples;
    std::vector<float> out(static_cast<std::size_t>(block));
    std::int64_t written = 0;
    std::int64_t read = 0;
    std::int64_t largest_delay = 0;
    std::size_t underruns = 0;
    std::size_t reserve = buffer.reserve();
    const std::int64_t end = 120 * 48000;
    while (read < end) {
        read += block;
        const auto due = static_cast<std::int64_t>(static_cast<double>(read + block) * (1 + drift));
        samples.clear();
        // Exact in a float; times repeat after 2^22 samples.
        for (; written < due; ++written) samples.push_back(static_cast<float>(written % (1 << 22)));
        buffer.write(samples);
        buffer.read(out);
        if (buffer.reserve() != reserve) {
            reserve = buffer.reserve();
            ++underruns;
        } else if (out.back() > 0) {
            const auto delay = written % (1 << 22) - static_cast<std::int64_t>(out.back());
            if (delay > 0) largest_delay = std::max(largest_delay, delay);
        }
    }
    CAPTURE(block, drift, underruns, reserve);
    // An underrun adds a block to the reserve, which then lasts for as many samples of drift; the
    // reserve is limited to 0.2 s. A surplus of two blocks above the reserve is dropped after a
    // second.
    const double slips = std::abs(drift) * static_cast<double>(end) / block;
    if (drift < 0) {
        CHECK(static_cast<double>(underruns) <= slips + 1);
    } else {
        CHECK(underruns <= 1);
        CHECK(largest_delay <= static_cast<std::int64_t>(reserve) + 4 * block + 48);
    }
}

TEST_CASE("Input in portions of any size at the output's rate is output without a gap") {
    for (const int block : {1, 100, 256}) {
        CaptureBuffer buffer(kRate_hz, block);
        std::mt19937 random(9);
        std::uniform_int_distribution<int> jitter(0, 50);
        std::vector<float> out(static_cast<std::size_t>(block));
        int written = 0;
        int read = 0;
        float last = 0;
        bool contiguous = true;
        // A lead of 100 samples covers the jitter. The first samples fade in.
        while (read < 20000) {
            std::vector<float> samples;
            const int due = read + block + 100 + jitter(random);
            for (; written < due; ++written) samples.push_back(static_cast<float>(written));
            buffer.write(samples);
            buffer.read(out);
            read += block;
            for (const float x : out) {
                if (x > 1000) contiguous &= last < 1000 || x == last + 1;
                last = x;
            }
        }
        CAPTURE(block);
        CHECK(contiguous);
        CHECK(last > 19000);
    }
}

TEST_CASE("After an interruption the surplus is measured anew") {
    Line line;
    // Almost empty before the interruption.
    line.write(2 * kBlock);
    line.read(4);
    const std::size_t reserve = line.buffer().reserve();
    // It returns with 20 blocks too many, which are dropped after a second.
    line.write(reserve + 21 * kBlock);
    for (int i = 0; i < 48000 / kBlock + 2; ++i) {
        line.read();
        line.write(kBlock);
    }
    CHECK(line.drain() <= reserve / kBlock + 4);
    CHECK(line.largest_step() < kSmooth);
}

TEST_CASE("Blocks longer than a second are buffered") {
    constexpr int kLong = 8192;
    CaptureBuffer buffer(8000, kLong);
    const std::vector<float> in(kLong, 0.5F);
    std::vector<float> out(kLong);
    buffer.write(in);
    for (int i = 0; i < 5; ++i) {
        buffer.write(in);
        buffer.read(out);
        CHECK(out.back() == 0.5F);
    }
}
