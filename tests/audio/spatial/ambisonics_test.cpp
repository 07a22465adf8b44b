#include "audio/spatial/ambisonics.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "tests/audio/convolution/signals.h"
#include "tests/audio/spatial/directions.h"

using namespace aula;
using namespace aula::test;

namespace {

using Direction = std::array<float, 3>;

Direction random_direction(std::mt19937& random) {
    std::normal_distribution<double> normal;
    const double x = normal(random);
    const double y = normal(random);
    const double z = normal(random);
    const double length = std::hypot(x, y, z);
    return {static_cast<float>(x / length), static_cast<float>(y / length),
            static_cast<float>(z / length)};
}

/// Random rotations about x, y and z in sequence.
HeadRotation random_rotation(std::mt19937& random) {
    std::uniform_real_distribution<double> angle(-std::numbers::pi, std::numbers::pi);
    HeadRotation rotation = kNoRotation;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double a = angle(random);
        const std::size_t i = (axis + 1) % 3;
        const std::size_t j = (axis + 2) % 3;
        for (std::size_t c = 0; c < 3; ++c) {
            const double before_i{rotation[i][c]};
            const double before_j{rotation[j][c]};
            rotation[i][c] = static_cast<float>(std::cos(a) * before_i - std::sin(a) * before_j);
            rotation[j][c] = static_cast<float>(std::sin(a) * before_i + std::cos(a) * before_j);
        }
    }
    return rotation;
}

/// The channels of a plane wave from a direction.
Signals plane_wave(const Direction& direction, const Signal& signal, int order) {
    Signals channels(ambisonic_channels(order), signal);
    const auto gains = encode_direction(direction);
    for (std::size_t c = 0; c < channels.size(); ++c) {
        for (float& x : channels[c]) x *= gains[c];
    }
    return channels;
}

void turn(FieldRotation& rotation, Signals& field, std::size_t from, std::size_t to) {
    std::vector<float*> pointers;
    for (Signal& channel : field) pointers.push_back(channel.data() + from);
    rotation.process(pointers, to - from);
}

}  // namespace

TEST_CASE("Harmonics are orthogonal over the sphere with the SN3D energies 1 / (2 l + 1)") {
    // Quadrature over a Fibonacci lattice, whose error decreases as 1 / points.
    constexpr std::size_t kPoints = 20000;
    std::array<std::array<double, 16>, 16> products{};
    for (const Direction& direction : uniform_directions(kPoints)) {
        const auto y = encode_direction(direction);
        for (std::size_t i = 0; i < 16; ++i) {
            for (std::size_t j = 0; j < 16; ++j) {
                products[i][j] += double{y[i]} * double{y[j]} / kPoints;
            }
        }
    }
    for (std::size_t i = 0; i < 16; ++i) {
        for (std::size_t j = 0; j < 16; ++j) {
            const double expected = i == j ? 1.0 / (2 * order_of_channel(i) + 1) : 0;
            CHECK(products[i][j] == Approx(expected).margin(1e-3));
        }
    }
    // AmbiX: the first channels point left, up and to the front.
    CHECK(encode_direction({0, 1, 0})[1] == 1);
    CHECK(encode_direction({0, 0, 1})[2] == 1);
    CHECK(encode_direction({1, 0, 0})[3] == 1);
}

TEST_CASE("Rotating a field equals encoding rotated directions, in every order") {
    std::mt19937 random(1);
    for (int order = 0; order <= kHighestAmbisonicOrder; ++order) {
        double worst = 0;
        for (int trial = 0; trial < 200; ++trial) {
            const HeadRotation head = random_rotation(random);
            const Direction world = random_direction(random);
            FieldRotation rotation(order, 64);
            rotation.turn_to(head);
            Signals field = plane_wave(world, {1}, order);
            turn(rotation, field, 0, 1);
            const auto expected = encode_direction(in_head_axes(head, world));
            for (std::size_t c = 0; c < field.size(); ++c) {
                worst = std::max(worst, double{std::abs(field[c][0] - expected[c])});
            }
        }
        CAPTURE(order);
        // Rounding: a few dozen operations on numbers of magnitude 1.
        CHECK(worst < 5e-6);
    }
}

TEST_CASE("A turn is a linear crossfade of the rotated fields for any call size") {
    std::mt19937 random(2);
    const HeadRotation before = random_rotation(random);
    const HeadRotation after = random_rotation(random);
    const Direction world = random_direction(random);
    constexpr std::size_t kGlide = 256;
    const Signal noise = random_signals(1, 1000, 3)[0];
    for (const std::size_t call : {1000U, 256U, 37U}) {
        FieldRotation rotation(3, kGlide);
        rotation.turn_to(before);
        Signals field = plane_wave(world, noise, 3);
        for (std::size_t n = 0; n < 1000; n += call) {
            if (n >= 300) rotation.turn_to(after);
            turn(rotation, field, n, std::min<std::size_t>(n + call, 1000));
        }
        const std::size_t begin = (300 + call - 1) / call * call;
        const auto from = encode_direction(in_head_axes(before, world));
        const auto to = encode_direction(in_head_axes(after, world));
        double worst = 0;
        for (std::size_t n = 0; n < 1000; ++n) {
            const double share =
                n < begin ? 0 : std::min(1.0, static_cast<double>(n - begin + 1) / kGlide);
            for (std::size_t c = 0; c < 16; ++c) {
                const double expected =
                    double{noise[n]} * ((1 - share) * double{from[c]} + share * double{to[c]});
                worst = std::max(worst, std::abs(double{field[c][n]} - expected));
            }
        }
        CAPTURE(call);
        // Rounding of noise of up to 4; steps are accumulated every 64 samples.
        CHECK(worst < 5e-5);
    }
}

TEST_CASE("A turn of the head about each axis rotates the field") {
    const Direction world{0.48F, 0.6F, 0.64F};
    const std::array<HeadRotation, 3> turns{{{{{1, 0, 0}, {0, 0, 1}, {0, -1, 0}}},    // roll
                                             {{{0, 0, 1}, {0, 1, 0}, {-1, 0, 0}}},    // pitch
                                             {{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}}}};  // yaw
    for (const HeadRotation& head : turns) {
        FieldRotation rotation(1, 64);
        rotation.turn_to(kNoRotation);
        Signals field = plane_wave(world, Signal(200, 1), 1);
        turn(rotation, field, 0, 100);
        rotation.turn_to(head);
        turn(rotation, field, 100, 200);
        const auto expected = encode_direction(in_head_axes(head, world));
        for (std::size_t c = 0; c < 4; ++c)
            CHECK(field[c][199] == Approx(double{expected[c]}).margin(1e-6));  // rounding
    }
}

TEST_CASE("A rotation keeps the energy of each order, and that of the reverse undoes it") {
    std::mt19937 random(5);
    for (int trial = 0; trial < 20; ++trial) {
        const HeadRotation head = random_rotation(random);
        HeadRotation back{};
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) back[i][j] = head[j][i];
        }
        // Any field, not only that of a plane wave.
        const Signals before = random_signals(16, 8, static_cast<unsigned>(trial));
        Signals field = before;
        FieldRotation there(3, 64);
        there.turn_to(head);
        turn(there, field, 0, 8);
        const auto energy = [](const Signals& channels, int order) {
            double sum = 0;
            for (std::size_t c = 0; c < 16; ++c) {
                for (const float x : channels[c])
                    if (order_of_channel(c) == order) sum += double{x} * double{x};
            }
            return sum;
        };
        for (int order = 0; order <= 3; ++order) {
            CAPTURE(order);
            // Rounding of elements: 1e-6 each, as in "Rotating a field ...".
            CHECK(energy(field, order) == Approx(energy(before, order)).epsilon(1e-5));
            const std::size_t last = ambisonic_channels(order) - 1;
            if (order > 0) CHECK(field[last] != before[last]);
        }
        FieldRotation again(3, 64);
        again.turn_to(back);
        turn(again, field, 0, 8);
        double worst = 0;
        for (std::size_t c = 0; c < 16; ++c) {
            for (std::size_t n = 0; n < 8; ++n)
                worst = std::max(worst, double{std::abs(field[c][n] - before[c][n])});
        }
        CHECK(worst < 2e-5);  // rounding, of noise of up to 4
    }
}

TEST_CASE("Two rotations one after the other are the rotation by their product, in each order") {
    std::mt19937 random(6);
    for (int order = 1; order <= 3; ++order) {
        const HeadRotation first = random_rotation(random);
        const HeadRotation second = random_rotation(random);
        HeadRotation both{};
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) {
                for (std::size_t k = 0; k < 3; ++k) both[i][j] += second[i][k] * first[k][j];
            }
        }
        const Signals before = random_signals(ambisonic_channels(order), 100, 7);
        Signals field = before;
        Signals expected = before;
        for (const HeadRotation& head : {first, second}) {
            FieldRotation rotation(order, 64);
            rotation.turn_to(head);
            turn(rotation, field, 0, 100);
        }
        FieldRotation rotation(order, 64);
        rotation.turn_to(both);
        turn(rotation, expected, 0, 100);
        double worst = 0;
        double moved = 0;
        for (std::size_t c = 0; c < field.size(); ++c) {
            for (std::size_t n = 0; n < 100; ++n) {
                worst = std::max(worst, double{std::abs(field[c][n] - expected[c][n])});
                moved = std::max(moved, double{std::abs(field[c][n] - before[c][n])});
            }
        }
        CAPTURE(order);
        CHECK(worst < 2e-5);  // rounding, of noise of up to 4
        CHECK(moved > 1);
    }
}

TEST_CASE("A turn of the head during a turn starts from the present rotation") {
    const auto yaw = [](double angle) {
        const auto c = static_cast<float>(std::cos(angle));
        const auto s = static_cast<float>(std::sin(angle));
        return HeadRotation{{{c, s, 0}, {-s, c, 0}, {0, 0, 1}}};
    };
    FieldRotation rotation(3, 100);
    Signals field = plane_wave({0.6F, 0.64F, 0.48F}, Signal(300, 1), 3);
    rotation.turn_to(yaw(0));
    turn(rotation, field, 0, 50);
    rotation.turn_to(yaw(1));
    turn(rotation, field, 50, 90);
    rotation.turn_to(yaw(-0.5));
    turn(rotation, field, 90, 300);
    const auto expected = encode_direction(in_head_axes(yaw(-0.5), {0.6F, 0.64F, 0.48F}));
    for (std::size_t c = 0; c < 16; ++c) {
        float largest = 0;
        for (std::size_t n = 1; n < 300; ++n)
            largest = std::max(largest, std::abs(field[c][n] - field[c][n - 1]));
        CAPTURE(c);
        // Channels change by at most 2 in a glide of 100 samples, by far more in a jump.
        CHECK(largest < 0.021F);
        // It arrives 100 samples after the newest turn.
        CHECK(field[c][189] == Approx(expected[c]).margin(5e-6));
        CHECK(field[c][299] == Approx(expected[c]).margin(5e-6));
    }
}

TEST_CASE("The order of a channel and the channels of an order belong together") {
    std::size_t channel = 0;
    for (int order = 0; order <= kHighestAmbisonicOrder; ++order) {
        for (int m = -order; m <= order; ++m) CHECK(order_of_channel(channel++) == order);
        CHECK(ambisonic_channels(order) == channel);
    }
    CHECK(channel == kMaxAmbisonicChannels);
}
