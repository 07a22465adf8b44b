#include "apps/room/base/room_exchange.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <memory>
#include <vector>

namespace room_exchange_test {

namespace {

using namespace aula;

constexpr int kBlock = 100;
constexpr double kRate_hz = 10'000;  // a fade has 500 samples
constexpr std::int64_t kTail = 3000;

/// A room with a number and a tail.
struct Room {
    explicit Room(int number_in) : number(number_in) {}
    std::int64_t tail_samples() const noexcept { return kTail; }
    int number;
};

/// Rooms that are published before blocks, with the weights of their inputs and outputs.
struct Played {
    /// `change(block, rooms)` publishes rooms.
    Played(int blocks, const std::function<void(int, Mailbox<Room>&)>& change,
           const std::function<bool(const Room&)>& fades_in = {}) {
        Mailbox<Room> rooms(RoomExchange<Room>::kMaxHeld);
        RoomExchange<Room> exchange(rooms, kRate_hz, kBlock);
        inputs.resize(20, std::vector<float>(static_cast<std::size_t>(blocks * kBlock)));
        outputs = inputs;
        for (int block = 0; block < blocks; ++block) {
            change(block, rooms);
            if (fades_in)
                exchange.advance(fades_in);
            else
                exchange.advance();
            std::size_t sounding = 0;
            exchange.render(kBlock, [&](Room& room, std::span<const float> input,
                                        std::span<const float> output) {
                ++sounding;
                const auto of = static_cast<std::size_t>(room.number);
                for (int n = 0; n < kBlock; ++n) {
                    const auto i = static_cast<std::size_t>(n);
                    const auto at = static_cast<std::size_t>(block * kBlock + n);
                    inputs[of][at] = input.empty() ? 1 : input[i];
                    outputs[of][at] = output.empty() ? 1 : output[i];
                }
            });
            most = std::max(most, sounding);
            tails.push_back(exchange.tail_samples());
            while (rooms.reclaim()) ++back;
        }
    }

    /// The sum of the weights of all inputs at a sample.
    double sum(std::size_t sample) const {
        double sum = 0;
        for (const std::vector<float>& room : inputs) sum += static_cast<double>(room[sample]);
        return sum;
    }

    /// The largest step of a weight of inputs or outputs of a room, from sample to sample.
    float largest_step(std::size_t room, const std::vector<std::vector<float>>& weights) const {
        float step = 0;
        for (std::size_t n = 1; n < weights[room].size(); ++n)
            step = std::max(step, std::abs(weights[room][n] - weights[room][n - 1]));
        return step;
    }

    std::vector<std::vector<float>> inputs;   ///< [room][sample] weights
    std::vector<std::vector<float>> outputs;  ///< likewise
    std::vector<std::int64_t> tails;          ///< [block]
    std::size_t most = 0;                     ///< rooms that sound at a time
    int back = 0;                             ///< rooms that have been given back
};

/// The steepest step of a raised cosine of 500 samples, with rounding.
constexpr float kStep = 1.05F * 3.1416F / 2 / 500;

}  // namespace

TEST_CASE("The weights of the inputs of exchanged rooms add up to one, also in quick succession") {
    const Played played(120, [](int block, Mailbox<Room>& rooms) {
        if (block == 0) rooms.publish(std::make_unique<Room>(0));
        if (block == 10) rooms.publish(std::make_unique<Room>(1));
        if (block == 13) rooms.publish(std::make_unique<Room>(2));  // while 1 fades in
    });
    double worst = 0;
    for (std::size_t n = 0; n < played.inputs[0].size(); ++n)
        worst = std::max(worst, std::abs(played.sum(n) - 1));
    CHECK(worst < 1e-6);  // rounding
    CHECK(played.inputs[0][0] == 1);
    CHECK(played.inputs[2].back() == 1);
    for (std::size_t room = 1; room < 3; ++room)
        CHECK(played.largest_step(room, played.inputs) < kStep);
    CHECK(played.most == 3);
    CHECK(played.back == 2);
}

TEST_CASE("A room rings out for its tail and both fades, and fades out then") {
    const Played played(80, [](int block, Mailbox<Room>& rooms) {
        if (block == 0) rooms.publish(std::make_unique<Room>(0));
        if (block == 10) rooms.publish(std::make_unique<Room>(1));
    });
    const auto last = static_cast<std::size_t>(1000 + kTail + 2 * 500);
    CHECK(played.outputs[0][last - 1] == 1);
    CHECK(played.outputs[0][last + 250] < 0.6F);
    CHECK(played.outputs[0][last + 250] > 0.4F);
    CHECK(played.outputs[0][last + 500] == 0);
    CHECK(played.back == 1);
    // The tail is that of the room that plays, or longer while one rings out.
    CHECK(played.tails[5] == kTail);
    CHECK(played.tails[10] > kTail);
    CHECK(played.tails.back() == kTail);
}

TEST_CASE("A further room waits until the oldest of two that ring out has faded out") {
    const Played played(60, [](int block, Mailbox<Room>& rooms) {
        if (block % 10 == 0 && block < 40) rooms.publish(std::make_unique<Room>(block / 10));
    });
    CHECK(played.most == 3);
    CHECK(played.inputs[3][3000] == 0);
    // The first one fades out for 500 samples, then the last one begins.
    CHECK(played.outputs[0][3250] < 0.6F);
    CHECK(played.outputs[0][3250] > 0.4F);
    CHECK(played.outputs[0][3600] == 0);
    CHECK(played.inputs[3][3400] == 0);
    CHECK(played.inputs[3][4200] == 1);
    double worst = 0;
    for (std::size_t n = 0; n < played.inputs[0].size(); ++n)
        worst = std::max(worst, std::abs(played.sum(n) - 1));
    CHECK(worst < 1e-6);
}

TEST_CASE("A room that begins anew does not fade in, and the first one may") {
    const Played played(
        40,
        [](int block, Mailbox<Room>& rooms) {
            if (block == 0) rooms.publish(std::make_unique<Room>(0));
            if (block == 20) rooms.publish(std::make_unique<Room>(1));
        },
        [](const Room& room) { return room.number == 0; });
    CHECK(played.inputs[0][0] < 0.01F);
    CHECK(played.inputs[0][600] == 1);
    CHECK(played.inputs[1][2000] == 1);
    CHECK(played.inputs[0][2250] == Approx(0.5).margin(0.02));
    CHECK(played.inputs[0][2600] == 0);
}

TEST_CASE("Without a wait the oldest room fades out meanwhile, and ends at the fourth change") {
    Mailbox<Room> rooms(RoomExchange<Room>::kMaxHeld);
    RoomExchange<Room> exchange(rooms, kRate_hz, kBlock);
    std::vector<std::size_t> sounding;
    for (int block = 0; block < 12; ++block) {
        if (block % 2 == 0) {
            rooms.publish(std::make_unique<Room>(block / 2));
            exchange.advance_now(block > 0);
            CHECK(exchange.playing()->number == block / 2);
        }
        std::size_t count = 0;
        exchange.render(kBlock,
                        [&](Room&, std::span<const float>, std::span<const float>) { ++count; });
        sounding.push_back(count);
        while (rooms.reclaim()) {
        }
    }
    CHECK(*std::max_element(sounding.begin(), sounding.end()) == RoomExchange<Room>::kMaxHeld);
}

}  // namespace room_exchange_test
