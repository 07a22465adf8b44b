#include "tests/engine/waves/exact_box.h"

#include <cmath>
#include <numbers>

namespace aula::test {

namespace {

using Complex = std::complex<double>;
constexpr double kPi = std::numbers::pi;

/// A damped mode along an axis: p = cos(K x) + B sin(K x), with p' = j k b0 p at 0 and -j k b1 p at
/// the far end.
struct AxisMode {
    Complex k;
    Complex sine;
    Complex norm;

    Complex at(double x) const { return std::cos(k * x) + sine * std::sin(k * x); }
};

AxisMode axis_mode(double length, const std::array<double, 2>& admittance, Complex wave_number,
                   int order) {
    const Complex j(0, 1);
    const double sum = admittance[0] + admittance[1];
    const double product = admittance[0] * admittance[1];
    if (sum == 0) {
        const double k = order * kPi / length;
        return {Complex(k), 0, Complex(order == 0 ? length : length / 2)};
    }
    Complex k = std::sqrt(std::pow(order * kPi / length, 2) +
                          j * wave_number * (order == 0 ? 1.0 : 2.0) * sum / length);
    for (int part = 1; part <= 3; ++part) {  // in steps of the admittance, by Newton's method
        const double share = part / 3.0;
        const double b = sum * share;
        const double q = product * share * share;
        for (int i = 0; i < 12; ++i) {
            const Complex s = std::sin(k * length);
            const Complex c = std::cos(k * length);
            const Complex f =
                k * s - j * wave_number * b * c + wave_number * wave_number * q / k * s;
            const Complex slope = s + k * length * c + j * wave_number * b * length * s +
                                  wave_number * wave_number * q * (length * c / k - s / (k * k));
            k -= f / slope;
        }
    }
    const Complex sine = j * wave_number * admittance[0] / k;
    const Complex s = std::sin(k * length);
    return {k, sine,
            length / 2 * (1.0 + sine * sine) +
                std::sin(2.0 * k * length) / (4.0 * k) * (1.0 - sine * sine) + sine * s * s / k};
}

}  // namespace

std::vector<std::vector<Complex>> exact_box(const DampedBox& box, const Vec3& source,
                                            const std::vector<Vec3>& receivers,
                                            const std::vector<double>& wave_numbers,
                                            double highest) {
    const Complex j(0, 1);
    std::vector<std::vector<Complex>> result(receivers.size(),
                                             std::vector<Complex>(wave_numbers.size()));
    const double length{box.size.x};
    for (std::size_t f = 0; f < wave_numbers.size(); ++f) {
        const double k = wave_numbers[f];
        std::array<std::vector<AxisMode>, 2> modes;  // along y and z
        for (int axis = 0; axis < 2; ++axis) {
            const double across{box.size[axis + 1]};
            for (int n = 0; n * kPi / across <= highest; ++n) {
                modes[static_cast<std::size_t>(axis)].push_back(
                    axis_mode(across, box.admittance[static_cast<std::size_t>(axis) + 1], k, n));
            }
        }
        // Values at the source over the norm, and at the receivers.
        std::array<std::vector<Complex>, 2> sent;
        std::array<std::vector<std::vector<Complex>>, 2> received;
        for (int axis = 0; axis < 2; ++axis) {
            const auto a = static_cast<std::size_t>(axis);
            received[a].resize(receivers.size());
            for (const AxisMode& mode : modes[a]) {
                sent[a].push_back(mode.at(double{source[axis + 1]}) / mode.norm);
                for (std::size_t r = 0; r < receivers.size(); ++r) {
                    received[a][r].push_back(mode.at(double{receivers[r][axis + 1]}));
                }
            }
        }
        for (std::size_t y = 0; y < modes[0].size(); ++y) {
            for (std::size_t z = 0; z < modes[1].size(); ++z) {
                if (std::hypot(static_cast<double>(y) / double{box.size.y},
                               static_cast<double>(z) / double{box.size.z}) *
                        kPi >
                    highest) {
                    break;
                }
                Complex g = std::sqrt(k * k - modes[0][y].k * modes[0][y].k -
                                      modes[1][z].k * modes[1][z].k);
                if (g.imag() > 0) g = -g;  // exp(-j g x) decays
                const Complex near =
                    (g - k * box.admittance[0][0]) / (g + k * box.admittance[0][0]);
                const Complex far = (g - k * box.admittance[0][1]) / (g + k * box.admittance[0][1]);
                const auto wave = [&](double path) { return std::exp(-j * g * path); };
                const Complex scale = 4 * kPi /
                                      (2.0 * j * g * (1.0 - near * far * wave(2 * length))) *
                                      sent[0][y] * sent[1][z];
                for (std::size_t r = 0; r < receivers.size(); ++r) {
                    const double x{source.x};
                    const double to{receivers[r].x};
                    const double apart = std::abs(to - x);
                    result[r][f] +=
                        scale * received[0][r][y] * received[1][r][z] *
                        (wave(apart) + near * wave(x + to) + far * wave(2 * length - x - to) +
                         near * far * wave(2 * length - apart));
                }
            }
        }
    }
    return result;
}

Complex exact_pole(const DampedBox& box, const std::array<int, 3>& order) {
    Complex k = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        k += std::pow(order[axis] * kPi / double{box.size[static_cast<int>(axis)]}, 2);
    }
    k = std::sqrt(k);
    // A fixed point, because the modes along the axes depend on k.
    for (int i = 0; i < 30; ++i) {
        Complex k2 = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const Complex part = axis_mode(double{box.size[static_cast<int>(axis)]},
                                           box.admittance[axis], k, order[axis])
                                     .k;
            k2 += part * part;
        }
        k = (k + std::sqrt(k2)) / 2.0;
    }
    return Complex(0, 1) * k;
}

}  // namespace aula::test
