#include "engine/edges/wedge_integral.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "process/multiversion.h"

namespace aula {

namespace {

/// Detour to a boundary of geometrical acoustics that keeps the pole off the path of integration:
/// the field of a half plane differs by 7e-4 of free field from that at the boundary at 8 kHz.
constexpr double kLeastDetour_m = 1e-8;

/// q_0 = 2^-38 m = 3.6e-12 m, 2^-10 of the scale of kLeastDetour_m: see kBelowScale.
constexpr int kFirstNodeExponent = -38;
static_assert(kLeastDetour_m > 1024.0 / (std::int64_t{1} << 38));

/// The last node is 2^5 m, where exp(-k q) is 1e-16 at 63 Hz.
constexpr int kNodeCount = 44;

/// beta_1 to beta_4.
constexpr std::size_t kTerms = 4;

/// Open angles as near to those of a half plane or a right angle have their faster formulas: about
/// 1e-6 of the field.
constexpr double kSameIndex = 1e-6;

constexpr std::array<double, kNodeCount> kNode_m = [] {
    std::array<double, kNodeCount> nodes{};
    double q = 1;
    for (int i = 0; i < -kFirstNodeExponent; ++i) q /= 2;
    for (double& node : nodes) {
        node = q;
        q *= 2;
    }
    return nodes;
}();

/// A complex number per node.
struct NodeValues {
    alignas(64) std::array<double, kNodeCount> re;
    alignas(64) std::array<double, kNodeCount> im;
};

/// cosh(eta) - 1, sinh(eta) and exp(eta) - 1 at the nodes from `first`.
struct Hyperbolics {
    NodeValues cosine;
    NodeValues sine;
    NodeValues exponential;
};

/// cosh(eta) - 1 = d (2 L0 + d) / (2 rS rR) with d = Lc - L0 - i q, without cancellation.
/// sinh(eta) = sqrt(c (c + 2)) is the root with a negative imaginary part.
AULA_MULTIVERSION
void find_hyperbolics(int first, double beyond_apex_m, double apex_m, double product_m2,
                      Hyperbolics& out) {
    const double d = beyond_apex_m;
    for (int node = first; node < kNodeCount; ++node) {
        const double q = kNode_m[static_cast<std::size_t>(node)];
        const double c_re = (d * (2 * apex_m + d) - q * q) / (2 * product_m2);
        const double c_im = -2 * q * (apex_m + d) / (2 * product_m2);
        const double x = c_re * (c_re + 2) - c_im * c_im;
        const double y = 2 * c_im * (c_re + 1);
        const double larger = std::sqrt((std::sqrt(x * x + y * y) + std::abs(x)) / 2);
        const double smaller = y / (2 * larger);
        const double sign = x >= 0 && y > 0 ? -1 : 1;
        const double s_re = sign * (x >= 0 ? larger : -smaller);
        const double s_im = sign * (x >= 0 ? smaller : -larger);
        const auto n = static_cast<std::size_t>(node);
        out.cosine.re[n] = c_re;
        out.cosine.im[n] = c_im;
        out.sine.re[n] = s_re;
        out.sine.im[n] = s_im;
        out.exponential.re[n] = c_re + s_re;
        out.exponential.im[n] = c_im + s_im;
    }
}

/// a = cosh(nu eta) - 1 for nu = 1/2, a half plane: sqrt(1 + c / 2) - 1 with c = cosh(eta) - 1,
/// without cancellation.
AULA_MULTIVERSION
void find_half_cosines(int first, const NodeValues& cosine, NodeValues& a) {
    for (int node = first; node < kNodeCount; ++node) {
        const auto n = static_cast<std::size_t>(node);
        const double c_re = cosine.re[n] / 2;
        const double c_im = cosine.im[n] / 2;
        // The root of a number with a negative imaginary part.
        const double x = 1 + c_re;
        const double larger = std::sqrt((std::sqrt(x * x + c_im * c_im) + std::abs(x)) / 2);
        const double smaller = -c_im / (2 * larger);
        const double r_re = 1 + (x >= 0 ? larger : smaller);
        const double r_im = -(x >= 0 ? smaller : larger);
        const double per = 1 / (r_re * r_re + r_im * r_im);
        a.re[n] = (c_re * r_re + c_im * r_im) * per;
        a.im[n] = (c_im * r_re - c_re * r_im) * per;
    }
}

/// a = cosh(nu eta) - 1 for nu = 2/3, a right angle: 2 sinh^2(eta / 3), with w = exp(eta / 3) = 1 +
/// u the cube root of z = exp(eta) = 1 + e. Halley's iteration w -> w + w (z - w^3) / (2 w^3 + z)
/// keeps u free of cancellation, as z - w^3 = e - u (3 + u (3 + u)). It begins within 8 %: with the
/// exponent of |z|^2 divided by 6, and cos(arg / 3) = (1 + cos(arg / 2)) / 2. The third iteration
/// then is exact.
AULA_MULTIVERSION
void find_cosines_of_right_angle(int first, const NodeValues& exponential, NodeValues& a) {
    for (int node = first; node < kNodeCount; ++node) {
        const auto n = static_cast<std::size_t>(node);
        const double e_re = exponential.re[n];
        const double e_im = exponential.im[n];
        const double z_re = 1 + e_re;
        const double square = z_re * z_re + e_im * e_im;
        const auto bits = std::bit_cast<std::int32_t>(static_cast<float>(square));
        constexpr std::int32_t kBitsOf1 = 0x3f800000;
        const auto sixth = static_cast<std::int32_t>(static_cast<float>(bits - kBitsOf1) / 6.0F);
        const double size = double{std::bit_cast<float>(kBitsOf1 + sixth)};
        const double half_cosine = std::sqrt(std::max(0.0, 0.5 * (1 + z_re / std::sqrt(square))));
        const double cosine = 0.5 * (1 + half_cosine);
        double u_re = size * cosine - 1;
        double u_im = -size * std::sqrt(std::max(0.0, 1 - cosine * cosine));
        for (int i = 0; i < 3; ++i) {
            // g = u (3 + u (3 + u)) = w^3 - 1
            const double p_re = 3 + u_re * (3 + u_re) - u_im * u_im;
            const double p_im = u_im * (3 + 2 * u_re);
            const double g_re = u_re * p_re - u_im * p_im;
            const double g_im = u_re * p_im + u_im * p_re;
            const double f_re = e_re - g_re;
            const double f_im = e_im - g_im;
            const double v_re = 3 + 2 * g_re + e_re;
            const double v_im = 2 * g_im + e_im;
            const double w_re = 1 + u_re;
            const double t_re = w_re * f_re - u_im * f_im;
            const double t_im = w_re * f_im + u_im * f_re;
            const double per = 1 / (v_re * v_re + v_im * v_im);
            u_re += (t_re * v_re + t_im * v_im) * per;
            u_im += (t_im * v_re - t_re * v_im) * per;
        }
        // a = 2 sinh^2 = u^2 (u + 2)^2 / (2 (1 + u)^2)
        const double w_re = 1 + u_re;
        const double m_re = u_re * (u_re + 2) - u_im * u_im;
        const double m_im = 2 * u_im * (u_re + 1);
        const double per = 1 / (w_re * w_re + u_im * u_im);
        const double h_re = (m_re * w_re + m_im * u_im) * per;
        const double h_im = (m_im * w_re - m_re * u_im) * per;
        a.re[n] = 0.5 * (h_re * h_re - h_im * h_im);
        a.im[n] = h_re * h_im;
    }
}

/// a = cosh(nu eta) - 1 = 2 sinh^2(nu eta / 2).
void find_cosines(int first, double nu, const NodeValues& exponential, NodeValues& a) {
    for (int node = first; node < kNodeCount; ++node) {
        const auto n = static_cast<std::size_t>(node);
        const double e_re = exponential.re[n];
        const double e_im = exponential.im[n];
        const double growth =
            nu / 4 * std::log1p(e_re * (2 + e_re) + e_im * e_im);  // Re(nu eta / 2)
        const double turn = nu / 2 * std::atan2(e_im, 1 + e_re);   // Im(nu eta / 2)
        const double m = std::expm1(growth);
        const double sinh_re = m * (m + 2) / (2 * (m + 1)) * std::cos(turn);
        const double sinh_im = (1 + m * m / (2 * (m + 1))) * std::sin(turn);
        a.re[n] = 2 * (sinh_re * sinh_re - sinh_im * sinh_im);
        a.im[n] = 4 * sinh_re * sinh_im;
    }
}

/// Parts of the field: incident, first face, second face.
constexpr std::size_t kParts = 3;

/// B(q) q at the nodes, [part].
using PartValues = std::array<NodeValues, kParts>;

AULA_MULTIVERSION
void find_parts(int first, double first_weight, const NodeValues& sine, const NodeValues& a,
                const std::array<double, kTerms>& factor,
                const std::array<double, kTerms>& twice_square, PartValues& parts) {
    for (int node = first; node < kNodeCount; ++node) {
        const auto n = static_cast<std::size_t>(node);
        const double s_re = sine.re[n];
        const double s_im = sine.im[n];
        const double weight = node > first ? 1 : first_weight;
        const double per_s = kNode_m[n] * weight / (s_re * s_re + s_im * s_im);
        const double t_re = s_re * per_s;
        const double t_im = -s_im * per_s;
        std::array<double, kTerms> b_re;
        std::array<double, kTerms> b_im;
        for (std::size_t i = 0; i < kTerms; ++i) {
            const double n_re = a.re[n] + twice_square[i];
            const double n_im = a.im[n];
            const double per_n = factor[i] / (n_re * n_re + n_im * n_im);
            b_re[i] = (t_re * n_re + t_im * n_im) * per_n;
            b_im[i] = (t_im * n_re - t_re * n_im) * per_n;
        }
        parts[0].re[n] = b_re[0] + b_re[1];
        parts[0].im[n] = b_im[0] + b_im[1];
        parts[1].re[n] = b_re[2];
        parts[1].im[n] = b_im[2];
        parts[2].re[n] = b_re[3];
        parts[2].im[n] = b_im[3];
    }
}

/// Sums of a part over the nodes, for each band. `decay`: exp(-k q) at node j for band b: [j + b].
AULA_MULTIVERSION
void sum_bands(int first, const NodeValues& part, const double* decay, double* re, double* im) {
    for (int node = first; node < kNodeCount; ++node) {
        const auto n = static_cast<std::size_t>(node);
        for (std::size_t b = 0; b < kBandCount; ++b) {
            re[b] += part.re[n] * decay[n + b];
            im[b] += part.im[n] * decay[n + b];
        }
    }
}

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

double apex_m(const WedgePoint& a, const WedgePoint& b) {
    return (a.along_m * b.radius_m + b.along_m * a.radius_m) / (a.radius_m + b.radius_m);
}

double length_over_m(const WedgePoint& a, const WedgePoint& b, double along_m) {
    return std::hypot(a.radius_m, a.along_m - along_m) +
           std::hypot(b.radius_m, b.along_m - along_m);
}

ComplexBands WedgeField::total() const {
    ComplexBands sum;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        sum[b] = incident[b] + first_face[b] + second_face[b];
    }
    return sum;
}

WedgeIntegral::WedgeIntegral(double speed_of_sound_m_s)
    : lowest_wave_number_per_m_(2 * std::numbers::pi * 62.5 / speed_of_sound_m_s) {
    static_assert(kNodes == kNodeCount);
    // The bands are octaves, as the nodes are: exp(-k_b q_j) depends on j + b only.
    for (std::size_t n = 0; n < decay_.size(); ++n) {
        decay_[n] = std::exp(-lowest_wave_number_per_m_ *
                             std::ldexp(1.0, static_cast<int>(n) + kFirstNodeExponent));
    }
}

bool WedgeIntegral::is_lit(const WedgePoint& source, const WedgePoint& receiver) {
    return std::abs(receiver.angle_rad - source.angle_rad) < std::numbers::pi;
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
    terms.index = std::numbers::pi / wedge.open_angle_rad;
    for (const double index : {0.5, 2.0 / 3}) {
        if (std::abs(terms.index - index) < kSameIndex) terms.index = index;
    }
    terms.product_m2 = source.radius_m * receiver.radius_m;
    terms.apex_m = std::hypot(across_m, dz_m);
    const double per_square_m = terms.product_m2 / terms.apex_m;  // detour = this x angle^2 / 2
    terms.scale_m = std::min(per_square_m, 1 / wave_number_per_m(kBandCount - 1));

    // Angles beyond the boundary of each term, positive on its lit side: the direct sound passes
    // the edge on either side; the faces mirror the source.
    const double s = source.angle_rad;
    const double r = receiver.angle_rad;
    const std::array<double, kTerms> beyond{
        std::numbers::pi - (r - s), std::numbers::pi - (s - r), std::numbers::pi - (s + r),
        std::numbers::pi - (2 * wedge.open_angle_rad - (s + r))};
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

    const double apex_along_m = apex_m(source, receiver);
    // Length beyond L0 of the path through a point of the edge.
    const auto beyond_apex_m = [&](double along_m) {
        return std::max(0.0, length_over_m(source, receiver, along_m) - terms.apex_m);
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
    const bool at_apex = beyond_apex_m < 8 * kNode_m[0];
    const double smallest_m = at_apex ? terms.scale_m : std::min(terms.scale_m, beyond_apex_m);
    // Below 2^-10 of the scale B is a power of q within a per mille.
    constexpr double kBelowScale = 1.0 / 1024;
    const int first =
        std::clamp(std::ilogb(smallest_m * kBelowScale) - kFirstNodeExponent, 0, kNodeCount - 1);

    Hyperbolics eta;
    best_version<find_hyperbolics>(first, beyond_apex_m, terms.apex_m, terms.product_m2, eta);
    NodeValues a;
    if (nu == 0.5) {
        best_version<find_half_cosines>(first, eta.cosine, a);
    } else if (nu == 2.0 / 3) {
        best_version<find_cosines_of_right_angle>(first, eta.exponential, a);
    } else {
        find_cosines(first, nu, eta.exponential, a);
    }
    // q / sinh(eta), with the weight of the series below the first node.
    constexpr double kSumOfRoots = 3.414213562373095;  // sum of 2^(-j/2): B ~ q^(-1/2)
    PartValues part_values;
    best_version<find_parts>(first, at_apex ? kSumOfRoots : 2, eta.sine, a, terms.sine,
                             terms.twice_square, part_values);
    std::array<std::array<double, kBandCount>, kParts> re{};
    std::array<std::array<double, kBandCount>, kParts> im{};
    for (std::size_t part = 0; part < kParts; ++part)
        best_version<sum_bands>(first, part_values[part], decay_.data(), re[part].data(),
                                im[part].data());

    // The step ln 2 of the trapezoid rule completes the factor i nu / (4 pi rS rR).
    const double scale =
        factor * nu * std::numbers::ln2 / (4 * std::numbers::pi * terms.product_m2);
    const std::array<ComplexBands*, 3> parts{&sum.incident, &sum.first_face, &sum.second_face};
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const double phase = wave_number_per_m(b) * (terms.apex_m + beyond_apex_m);
        const std::complex<double> turned = scale * std::polar(1.0, std::numbers::pi / 2 - phase);
        for (std::size_t part = 0; part < kParts; ++part) {
            (*parts[part])[b] += turned * std::complex<double>(re[part][b], im[part][b]);
        }
    }
}

}  // namespace aula
