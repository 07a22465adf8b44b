#include "engine/base/spherical_harmonics.h"

#include <cmath>
#include <numbers>

namespace aula {

// Y_lm = N_lm P_lm(z) / r^m times Re or Im of (x + iy)^m, r^2 = 1 - z^2, with
// N_lm^2 = (2 - delta_m0) (l - m)! / (l + m)!. Q_lm = P_lm / r^m are polynomials of z:
//     Q_mm = (2m - 1)!!,  Q_(m+1)m = (2m + 1) z Q_mm,
//     (l - m) Q_lm = (2l - 1) z Q_(l-1)m - (l + m - 1) Q_(l-2)m.
void spherical_harmonics(const Vec3& direction, int order, double* out) {
    const double x{direction.x};
    const double y{direction.y};
    const double z{direction.z};
    double cosine = 1;  // cosine of m times the azimuth, times r^m
    double sine = 0;
    double first = 1;  // Q_mm
    for (int m = 0; m <= order; ++m) {
        double before = 0;
        double q = first;
        double factor = m == 0 ? 1 : 2;  // N_lm^2
        for (int i = 1; i <= 2 * m; ++i) factor /= i;
        for (int l = m; l <= order; ++l) {
            const double scaled = std::sqrt(factor) * q;
            out[l * (l + 1) + m] = scaled * cosine;
            if (m > 0) out[l * (l + 1) - m] = scaled * sine;
            const double next = ((2 * l + 1) * z * q - (l + m) * before) / (l + 1 - m);
            before = q;
            q = next;
            factor *= static_cast<double>(l + 1 - m) / (l + 1 + m);
        }
        first *= 2 * m + 1;
        const double turned = cosine * x - sine * y;
        sine = cosine * y + sine * x;
        cosine = turned;
    }
}

}  // namespace aula
