#include "engine/edges/wedge_integral.h"

#include <algorithm>
#include <cmath>

namespace aula {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kLeastRadius_m = 0.05;
constexpr double kLeastDetour_m = 1e-8;
constexpr int kFirstNodeExponent = -38;  // q_0 = 2^-38 m = 3.6e-12 m
constexpr std::size_t kTerms = 4;

double node_m(int node) { return std::ldexp(1.0, node + kFirstNodeExponent); }

}  // namespace

/// Quantities of a pair of points that the integrals to the apex and to both ends share.
struct WedgeIntegral::Terms {
    double index;                             ///< nu = pi / open angle
    double product_m2;                        ///< rS rR
    double apex_m;                            ///< L0
    std::array<double, kTerms> sine;          ///< sin(nu phi_i)
    std::array<double, kTerms> twice_square;  ///< 2 sin^2(nu phi_i / 2) = 1 - cos(nu phi_i)
    double scale_m;                           ///< below which B(q) exp(-k q) is a power of q
};

ComplexBands WedgeField::total() const {
    ComplexBands sum;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        sum[b] = incident[b] + first_face[b] + second_face[b];
    }
    return sum;
}

WedgeIntegral::WedgeIntegral(double speed_of_sound_m_s)
    : lowest_wave_number_per_m_(2 * kPi * 62.5 / speed_of_sound_m_s) {
    // The bands are octaves, as the nodes are: exp(-k_b q_j) depends on j + b only.
    for (std::size_t n = 0; n < decay_.size(); ++n) {
        decay_[n] = std::exp(-lowest_wave_number_per_m_ * node_m(static_cast<int>(n)));
    }
}

bool WedgeIntegral::is_lit(const WedgePoint& source, const WedgePoint& receiver) {
    return std::abs(receiver.angle_rad - source.angle_rad) < kPi;
}

/// The field of the edge (Svensson, Fred, Vanderkooy 1999), with nu = pi / open angle:
///
///     H = -(nu / 4 pi) int_z1^z2 sum_i beta_i exp(-i k (m + l)) / (m l) dz,
///     beta_i = sin(nu phi_i) / (cosh(nu eta) - cos(nu phi_i)),
///     phi = pi + tS + tR, pi + tS - tR, pi - tS + tR, pi - tS - tR.
///
/// The length L = m + l of the path through a point of the edge fixes eta, by L^2 = rS^2 + rR^2 +
/// dz^2 + 2 rS rR cosh eta, on both sides of the apex. A half of the edge from the apex is thus an
/// integral over L, from its value L0 at the apex to that at the end. Each limit Lc contributes the
/// integral I(Lc) from Lc to i infinity along L = Lc - i q.
WedgeField WedgeIntegral::field(const Wedge& wedge, WedgePoint source, WedgePoint receiver) const {
    source.radius_m = std::max(source.radius_m, kLeastRadius_m);
    receiver.radius_m = std::max(receiver.radius_m, kLeastRadius_m);
    const double across_m = source.radius_m + receiver.radius_m;
    const double dz_m = source.along_m - receiver.along_m;
    Terms terms{};
    terms.index = kPi / wedge.open_angle_rad;
    terms.product_m2 = source.radius_m * receiver.radius_m;
    terms.apex_m = std::hypot(across_m, dz_m);
    const double per_square_m = terms.product_m2 / terms.apex_m;  // detour = this x angle^2 / 2
    terms.scale_m = std::min(per_square_m, 1 / wave_number_per_m(kBandCount - 1));

    // Angles beyond the boundary of each term, positive on its lit side: the direct sound passes
    // the edge on either side; the faces mirror the source.
    const double s = source.angle_rad;
    const double r = receiver.angle_rad;
    const std::array<double, kTerms> beyond{kPi - (r - s), kPi - (s - r), kPi - (s + r),
                                            kPi - (2 * wedge.open_angle_rad - (s + r))};
    const double least_rad = std::sqrt(2 * kLeastDetour_m / per_square_m);
    for (std::size_t i = 0; i < kTerms; ++i) {
        // On a boundary the pole meets the path of integration. Its side agrees with is_lit().
        double phi = beyond[i];
        if (std::abs(phi) < least_rad) phi = phi > 0 ? least_rad : -least_rad;
        const double half_sine = std::sin(terms.index * phi / 2);
        terms.sine[i] = std::sin(terms.index * phi);
        terms.twice_square[i] = 2 * half_sine * half_sine;
        terms.scale_m = std::min(
            terms.scale_m, per_square_m * terms.twice_square[i] / (terms.index * terms.index));
    }

    const double apex_along_m =
        (source.along_m * receiver.radius_m + receiver.along_m * source.radius_m) / across_m;
    // Length beyond L0 of the path through a point of the edge.
    const auto beyond_apex_m = [&](double along_m) {
        return std::max(0.0, std::hypot(source.radius_m, along_m - source.along_m) +
                                 std::hypot(receiver.radius_m, along_m - receiver.along_m) -
                                 terms.apex_m);
    };
    WedgeField sum;
    const bool above_low = apex_along_m > wedge.low_m;
    const bool below_high = apex_along_m < wedge.high_m;
    if (above_low && below_high) add_end(terms, 0, 2, sum);
    if (std::isfinite(wedge.low_m)) {
        add_end(terms, beyond_apex_m(wedge.low_m), above_low ? -1 : 1, sum);
    }
    if (std::isfinite(wedge.high_m)) {
        add_end(terms, beyond_apex_m(wedge.high_m), below_high ? -1 : 1, sum);
    }
    return sum;
}

/// Adds `factor` times
///
///     I(Lc) = (i nu / (4 pi rS rR)) exp(-i k Lc) int_0^inf B(q) exp(-k q) dq,
///     B = sum_i beta_i(eta) / sinh(eta),  L = Lc - i q,
///
/// Lc being `beyond_apex_m` longer than L0. The trapezoid rule in ln q with one node an octave errs
/// by exp(-pi^2 / ln 2), as the integrand is analytic in |Im ln q| < pi / 2. Below the first node B
/// is a power of q, and the rest of the geometric series is added to its weight.
void WedgeIntegral::add_end(const Terms& terms, double beyond_apex_m, double factor,
                            WedgeField& sum) const {
    const double nu = terms.index;
    const bool at_apex = beyond_apex_m < 8 * node_m(0);
    const double smallest_m = at_apex ? terms.scale_m : std::min(terms.scale_m, beyond_apex_m);
    constexpr double kBelowScale = 1.0 / 1024;
    const int first =
        std::clamp(std::ilogb(smallest_m * kBelowScale) - kFirstNodeExponent, 0, kNodes - 1);

    // Parts: incident, first face, second face.
    std::array<std::array<double, kBandCount>, 3> re{};
    std::array<std::array<double, kBandCount>, 3> im{};
    for (int node = first; node < kNodes; ++node) {
        const double q = node_m(node);
        // cosh(eta) - 1 = d (2 L0 + d) / (2 rS rR) with d = Lc - L0 - i q, without cancellation.
        const double d = beyond_apex_m;
        const double c_re = (d * (2 * terms.apex_m + d) - q * q) / (2 * terms.product_m2);
        const double c_im = -2 * q * (terms.apex_m + d) / (2 * terms.product_m2);
        // sinh(eta) = sqrt(c (c + 2)), the root with a negative imaginary part.
        const double x = c_re * (c_re + 2) - c_im * c_im;
        const double y = 2 * c_im * (c_re + 1);
        const double larger = std::sqrt((std::sqrt(x * x + y * y) + std::abs(x)) / 2);
        double s_re = x >= 0 ? larger : -y / (2 * larger);
        double s_im = x >= 0 ? y / (2 * larger) : -larger;
        if (s_im > 0) {
            s_re = -s_re;
            s_im = -s_im;
        }
        // eta = ln(1 + c + s); a = cosh(nu eta) - 1 = 2 sinh^2(nu eta / 2).
        const double e_re = c_re + s_re;
        const double e_im = c_im + s_im;
        const double growth =
            nu / 4 * std::log1p(e_re * (2 + e_re) + e_im * e_im);  // Re(nu eta / 2)
        const double turn = nu / 2 * std::atan2(e_im, 1 + e_re);   // Im(nu eta / 2)
        const double m = std::expm1(growth);
        const double sinh_re = m * (m + 2) / (2 * (m + 1)) * std::cos(turn);
        const double sinh_im = (1 + m * m / (2 * (m + 1))) * std::sin(turn);
        const double a_re = 2 * (sinh_re * sinh_re - sinh_im * sinh_im);
        const double a_im = 4 * sinh_re * sinh_im;
        // q / sinh(eta), with the weight of the series below the first node.
        constexpr double kSumOfRoots = 3.414213562373095;  // sum of 2^(-j/2): B ~ q^(-1/2)
        const double weight = node > first ? 1 : at_apex ? kSumOfRoots : 2;
        const double per_s = q * weight / (s_re * s_re + s_im * s_im);
        const double t_re = s_re * per_s;
        const double t_im = -s_im * per_s;
        std::array<double, kTerms> b_re;
        std::array<double, kTerms> b_im;
        for (std::size_t i = 0; i < kTerms; ++i) {
            const double n_re = a_re + terms.twice_square[i];
            const double per_n = terms.sine[i] / (n_re * n_re + a_im * a_im);
            b_re[i] = (t_re * n_re + t_im * a_im) * per_n;
            b_im[i] = (t_im * n_re - t_re * a_im) * per_n;
        }
        const std::array<double, 3> part_re{b_re[0] + b_re[1], b_re[2], b_re[3]};
        const std::array<double, 3> part_im{b_im[0] + b_im[1], b_im[2], b_im[3]};
        const double* decay = &decay_[static_cast<std::size_t>(node)];
        for (std::size_t part = 0; part < 3; ++part) {
            for (std::size_t b = 0; b < kBandCount; ++b) {
                re[part][b] += part_re[part] * decay[b];
                im[part][b] += part_im[part] * decay[b];
            }
        }
    }

    // The step ln 2 of the trapezoid rule completes the factor i nu / (4 pi rS rR).
    const double scale = factor * nu * std::numbers::ln2 / (4 * kPi * terms.product_m2);
    const std::array<ComplexBands*, 3> parts{&sum.incident, &sum.first_face, &sum.second_face};
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const double phase = wave_number_per_m(b) * (terms.apex_m + beyond_apex_m);
        const std::complex<double> turned = scale * std::polar(1.0, kPi / 2 - phase);
        for (std::size_t part = 0; part < 3; ++part) {
            (*parts[part])[b] += turned * std::complex<double>(re[part][b], im[part][b]);
        }
    }
}

}  // namespace aula
