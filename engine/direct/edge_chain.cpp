#include "engine/direct/edge_chain.h"

#include <algorithm>
#include <array>
#include <complex>
#include <glm/geometric.hpp>
#include <numbers>

#include "engine/base/tolerances.h"
#include "engine/direct/limits.h"
#include "engine/edges/edge_field.h"
#include "engine/edges/edge_passage.h"
#include "engine/edges/shortest_path.h"

namespace aula {

namespace {

/// Rays pass an edge that closely, and rays to the end of an edge end beside it.
constexpr double kBesideChain_m = tolerances::kApart_m + EdgePassage::kFromEnd_m;

/// Angle by which a path that is lit or not is on that side of a boundary: above rounding, and
/// below all that is heard.
constexpr double kLeastTurn_rad = 1e-6;

/// The products from both ends have a mean phase up to that angle from opposite phases, towards
/// which the field fades out. A choice: the mean turns by up to a quarter of the change of one of
/// them there.
constexpr double kOppositePhases_rad = std::numbers::pi / 4;

/// Cosine of the angle between the edges of a narrow face, up to 45 degrees: more than half of each
/// is beside the other. A choice.
constexpr double kAlongFace = 0.7;

/// Whether a point lies behind the faces of an edge, by more than rounding: a segment that ends at
/// a corner of a face may lie in the face.
bool is_behind(const DiffractionEdge& edge, const WedgePoint& point) {
    const double behind_rad =
        std::min(point.angle_rad - edge.open_angle_rad, 2 * std::numbers::pi - point.angle_rad);
    return behind_rad * point.radius_m > tolerances::kInPlane_m;
}

/// The end of a segment of a given length and direction from a point of an edge.
WedgePoint end_of(const DiffractionEdge& edge, double along_m, const glm::dvec3& direction,
                  double length_m, double angle_rad) {
    const double cosine = glm::dot(direction, edge.axis);
    const double radius_m = length_m * std::sqrt(std::max(0.0, 1 - cosine * cosine));
    return {std::max(radius_m, WedgeIntegral::kLeastRadius_m), angle_rad,
            along_m + length_m * cosine};
}

/// Divides a field by that of a source in free field at the length over a point of the edge.
void divide_by_free_field(const WedgePoint& source, const WedgePoint& receiver, double along_m,
                          const WedgeIntegral& integral, ComplexBands& field) {
    const double length_m = length_over_m(source, receiver, along_m);
    for (std::size_t b = 0; b < kBandCount; ++b) {
        field[b] *= std::polar(length_m, integral.wave_number_per_m(b) * length_m);
    }
}

/// Source and receiver at a half plane that a path bends around by an angle.
struct ScreenPoints {
    ScreenPoints(double turn_rad, WedgePoint from, WedgePoint to) : source(from), receiver(to) {
        source.angle_rad = (std::numbers::pi - turn_rad) / 2;
        receiver.angle_rad = source.angle_rad + std::numbers::pi + turn_rad;
    }
    WedgePoint source;
    WedgePoint receiver;
};

}  // namespace

std::optional<EdgeChain> EdgeChain::over(std::span<const DiffractionEdge* const> edges,
                                         const glm::dvec3& source, const glm::dvec3& listener) {
    const ShortestPath path = shortest_path(source, edges, listener);
    EdgeChain chain;
    chain.source_ = source;
    chain.listener_ = listener;
    chain.length_m_ = path.length_m;
    if (path.length_m >= glm::distance(source, listener) + limits::kLongestDetour_m) return {};
    double before_m = 0;
    glm::dvec3 last = source;
    for (std::size_t i = 0; i < edges.size(); ++i) {
        const glm::dvec3 apex = edges[i]->point(path.along_m[i]);
        before_m += glm::distance(last, apex);
        chain.contacts_.push_back(
            {.edge = edges[i], .apex = apex, .along_m = path.along_m[i], .before_m = before_m});
        last = apex;
    }
    if (!chain.find_angles() || !chain.find_bends()) return {};
    return chain;
}

glm::dvec3 EdgeChain::point(std::size_t index) const {
    if (index == 0) return source_;
    return index <= contacts_.size() ? contacts_[index - 1].apex : listener_;
}

/// A point of the path in the coordinates of an edge. An end in the plane of a screen counts as on
/// the side on which the paths over single edges have it.
WedgePoint EdgeChain::coordinates(const DiffractionEdge& edge, std::size_t index) const {
    if (index == 0) return edge.coordinates(source_, DiffractionEdge::kSourceSide);
    if (index <= contacts_.size()) return edge.coordinates(point(index));
    return edge.coordinates(listener_, DiffractionEdge::kListenerSide);
}

bool EdgeChain::find_angles() {
    for (std::size_t i = 0; i < contacts_.size(); ++i) {
        Contact& contact = contacts_[i];
        const WedgePoint before = coordinates(*contact.edge, i);
        const WedgePoint after = coordinates(*contact.edge, i + 2);
        if (std::min(before.radius_m, after.radius_m) < tolerances::kSame_m) return false;
        contact.in_rad = before.angle_rad;
        contact.out_rad = after.angle_rad;
    }
    for (std::size_t i = 0; i + 1 < contacts_.size(); ++i) {
        contacts_[i].shares_next = contacts_[i].edge->is_on_face(contacts_[i].out_rad) &&
                                   contacts_[i + 1].edge->is_on_face(contacts_[i + 1].in_rad);
    }
    for (std::size_t i = 0; i < contacts_.size(); ++i) {
        Contact& contact = contacts_[i];
        const WedgePoint before = coordinates(*contact.edge, i);
        const WedgePoint after = coordinates(*contact.edge, i + 2);
        const bool shares_last = i > 0 && contacts_[i - 1].shares_next;
        if ((is_behind(*contact.edge, before) && !shares_last) ||
            (is_behind(*contact.edge, after) && !contact.shares_next)) {
            return false;
        }
        contact.in_rad = contact.edge->open_angle_of(before);
        contact.out_rad = contact.edge->open_angle_of(after);
    }
    for (std::size_t i = 0; i + 1 < contacts_.size(); ++i) {
        if (contacts_[i].shares_next) choose_face(i);
    }
    return true;
}

/// Moves a segment that lies in a face of both its edges to the side of the face that is open at
/// both. Between two free edges it is the side where the path bends more.
void EdgeChain::choose_face(std::size_t contact) {
    Contact& here = contacts_[contact];
    Contact& next = contacts_[contact + 1];
    const auto angle_on = [](const DiffractionEdge& edge, const glm::dvec3& side,
                             double angle_rad) {
        const double open_rad = edge.open_angle_rad;
        const bool first = edge.is_free() ? glm::dot(edge.direction(std::numbers::pi / 2), side) > 0
                                          : angle_rad < open_rad / 2;
        return first ? 0 : open_rad;
    };
    std::array<glm::dvec3, 2> sides;
    if (!here.edge->is_free()) {
        sides.fill(here.edge->normal_at(here.out_rad));
    } else if (!next.edge->is_free()) {
        sides.fill(next.edge->normal_at(next.in_rad));
    } else {
        const glm::dvec3 side = here.edge->normal_at(here.out_rad);
        sides = {side, -side};
    }
    double most_rad = -1;
    const double out_rad = here.out_rad;
    const double in_rad = next.in_rad;
    for (const glm::dvec3& side : sides) {
        const double here_rad = angle_on(*here.edge, side, out_rad);
        const double next_rad = angle_on(*next.edge, side, in_rad);
        const double bend_rad =
            std::abs(here_rad - here.in_rad) + std::abs(next.out_rad - next_rad);
        if (bend_rad > most_rad) {
            most_rad = bend_rad;
            here.out_rad = here_rad;
            next.in_rad = next_rad;
        }
    }
}

bool EdgeChain::find_bends() {
    for (std::size_t i = 0; i < contacts_.size();) {
        Bend bend{.first = i, .last = i, .is_curved = contacts_[i].edge->is_curved};
        while (bend.is_curved && contacts_[bend.last].shares_next &&
               contacts_[bend.last + 1].edge->is_curved) {
            ++bend.last;
        }
        double moment = 0;
        for (std::size_t k = bend.first; k <= bend.last; ++k) {
            const double angle_rad = contacts_[k].bend_rad();
            if (bend.first < bend.last && angle_rad < kLeastTurn_rad) return false;
            bend.turn_rad += angle_rad;
            moment += angle_rad * contacts_[k].before_m;
        }
        const Contact& first = contacts_[bend.first];
        const Contact& last = contacts_[bend.last];
        bend.middle_m =
            bend.turn_rad > 0 ? moment / bend.turn_rad : 0.5 * (first.before_m + last.before_m);
        // No half plane turns a path by more; it fades out before, see share().
        if (bend.is_curved && bend.turn_rad >= std::numbers::pi) return false;
        if (bend.is_curved && bend.first == bend.last) {
            WedgePoint before = coordinates(*first.edge, bend.first);
            WedgePoint after = coordinates(*first.edge, bend.first + 2);
            before.angle_rad = first.in_rad;
            after.angle_rad = first.out_rad;
            if (!first.edge->is_nearest(before, after)) return false;
        }
        const glm::dvec3 left = point(bend.first);
        const glm::dvec3 right = point(bend.last + 2);
        bend.beyond_m = glm::distance(left, first.apex) + last.before_m - first.before_m +
                        glm::distance(last.apex, right) - glm::distance(left, right);
        if (bend.turn_rad < 0 && bend.beyond_m >= limits::kLongestLitBend_m) return false;
        i = bend.last + 1;
        bends_.push_back(bend);
    }
    return true;
}

/// Whether a segment leads from one free edge of a screen without thickness to another.
bool EdgeChain::is_along_screen(std::size_t contact) const {
    return contacts_[contact].shares_next && contacts_[contact].edge->is_free() &&
           contacts_[contact + 1].edge->is_free();
}

/// The same path on all sides of the screens along which it leads. Where a screen is seen end-on,
/// the field over each of its edges is that of an infinite half plane, and only the sum with the
/// chains on both sides is the free field.
std::vector<EdgeChain> EdgeChain::sides() const {
    std::vector<EdgeChain> all{*this};
    const auto opposite = [](const DiffractionEdge& edge, double angle_rad) {
        return angle_rad < edge.open_angle_rad / 2 ? edge.open_angle_rad : 0;
    };
    for (std::size_t i = 0; i + 1 < contacts_.size(); ++i) {
        if (!is_along_screen(i)) continue;
        const std::size_t count = all.size();
        for (std::size_t k = 0; k < count; ++k) {
            EdgeChain other = all[k];
            other.contacts_[i].out_rad = opposite(*contacts_[i].edge, contacts_[i].out_rad);
            other.contacts_[i + 1].in_rad =
                opposite(*contacts_[i + 1].edge, contacts_[i + 1].in_rad);
            other.bends_.clear();
            if (other.find_bends()) all.push_back(std::move(other));
        }
        for (EdgeChain& chain : all) chain.place_ends(i);
    }
    return all;
}

/// Where the point before or after a segment along a screen lies almost in its plane, the side on
/// which the other edge has it decides whether the edge is lit, as for the path over that edge.
void EdgeChain::place_ends(std::size_t contact) {
    const DiffractionEdge& first = *contacts_[contact].edge;
    const DiffractionEdge& second = *contacts_[contact + 1].edge;
    const auto is_same_side = [](const DiffractionEdge& edge, double a_rad, double b_rad) {
        return (a_rad < edge.open_angle_rad / 2) == (b_rad < edge.open_angle_rad / 2);
    };
    const bool is_before_here =
        is_same_side(second, coordinates(second, contact).angle_rad, contacts_[contact + 1].in_rad);
    const bool is_after_here =
        is_same_side(first, coordinates(first, contact + 3).angle_rad, contacts_[contact].out_rad);
    if (is_at_boundary(contact)) set_lit(contact, is_before_here);
    if (is_at_boundary(contact + 1)) set_lit(contact + 1, is_after_here);
}

bool EdgeChain::is_beside_screen(std::size_t edge) const {
    return (edge > 0 && is_along_screen(edge - 1)) ||
           (edge + 1 < contacts_.size() && is_along_screen(edge));
}

bool EdgeChain::is_at_boundary(std::size_t edge) const {
    const Contact& contact = contacts_[edge];
    if (contact.edge->is_curved) return false;
    const double before_m = glm::distance(point(edge), contact.apex);
    const double after_m = glm::distance(contact.apex, point(edge + 2));
    return std::abs(contact.bend_rad()) * before_m * after_m <
           kBesideChain_m * (before_m + after_m);
}

void EdgeChain::set_lit(std::size_t edge, bool is_lit) {
    Contact& contact = contacts_[edge];
    const double turn_rad =
        is_lit ? std::numbers::pi - kLeastTurn_rad : std::numbers::pi + kLeastTurn_rad;
    if ((contact.bend_rad() < 0) == is_lit) return;
    const double sign = contact.out_rad > contact.in_rad ? 1 : -1;
    double& angle_rad = contact.shares_next ? contact.in_rad : contact.out_rad;
    angle_rad =
        contact.shares_next ? contact.out_rad - sign * turn_rad : contact.in_rad + sign * turn_rad;
    for (Bend& bend : bends_) {
        if (bend.first == edge) bend.turn_rad = contact.bend_rad();
    }
}

std::size_t EdgeChain::narrow_faces(std::span<const DiffractionEdge* const> edges) {
    std::size_t faces = 0;
    for (std::size_t i = 1; i < edges.size(); ++i) {
        if (!edges[i - 1]->is_across_narrow_face(*edges[i])) continue;
        ++faces;
        ++i;  // a third edge is one of the next face
    }
    return faces;
}

std::size_t EdgeChain::order() const {
    std::vector<const DiffractionEdge*> edges;
    for (const Contact& contact : contacts_) edges.push_back(contact.edge);
    return bends_.size() - narrow_faces(edges);
}

std::vector<Vec3> EdgeChain::apexes() const {
    std::vector<Vec3> points;
    for (const Contact& contact : contacts_) points.push_back(Vec3(contact.apex));
    return points;
}

double EdgeChain::estimated_db(const WedgeIntegral& integral) const {
    double level_db = 0;
    for (const Bend& bend : bends_) {
        level_db -=
            20 * std::log10(limits::half_plane_loss(std::max(0.0, bend.beyond_m), integral));
    }
    return level_db;
}

double EdgeChain::opening(const SceneEdges& edges) const {
    double product = 1;
    Vec3 last(source_);
    for (std::size_t i = 0; i < contacts_.size(); ++i) {
        const Contact& contact = contacts_[i];
        const EdgePassage passage(*contact.edge, contact.along_m, contact.in_rad, contact.out_rad);
        const bool shares_last = i > 0 && contacts_[i - 1].shares_next;
        const bool is_seen =
            shares_last ? edges.visible_along_face(last, passage.point(0),
                                                   Vec3(contact.edge->normal_at(contact.in_rad)))
                        : edges.visible(last, passage.point(0));
        if (!is_seen) return 0;
        product *=
            passage.opening(edges.scene(), std::min(glm::distance(point(i), contact.apex),
                                                    glm::distance(contact.apex, point(i + 2))));
        if (product == 0) return 0;
        last = passage.point(1);
    }
    return edges.visible(last, Vec3(listener_)) ? product : 0;
}

/// The field of a bend alone relative to free field, its segments extended to the given lengths.
/// The edges of a curved surface act as a half plane in the middle of their turn.
ComplexBands EdgeChain::factor(const Bend& bend, double before_m, double after_m,
                               const WedgeIntegral& integral, const RayScene& scene) const {
    const auto toward = [&](std::size_t from, std::size_t to) {
        return glm::normalize(point(to) - point(from));
    };
    const glm::dvec3 back = toward(bend.first + 1, bend.first);
    const glm::dvec3 ahead = toward(bend.last + 1, bend.last + 2);
    const Contact& contact = contacts_[(bend.first + bend.last) / 2];
    const DiffractionEdge& edge = *contact.edge;
    const WedgePoint source = end_of(edge, contact.along_m, back, before_m, contact.in_rad);
    const WedgePoint receiver = end_of(edge, contact.along_m, ahead, after_m, contact.out_rad);
    ComplexBands field;
    if (bend.is_curved) {
        field = curved_field(integral, scene, edge, bend.turn_rad, source, receiver);
    } else {
        // At a shared face the direct sound and its reflection jump together.
        const bool shares_face =
            contact.shares_next || (bend.first > 0 && contacts_[bend.first - 1].shares_next);
        field = edge_field(integral, scene, edge, source, receiver, {.fade_lit = !shares_face});
    }
    divide_by_free_field(source, receiver, contact.along_m, integral, field);
    return field;
}

/// The field of an infinite half plane relative to free field, around which the path turns as
/// around all bends, at the middle of its turn.
ComplexBands EdgeChain::thin_screen(const WedgeIntegral& integral) const {
    glm::dvec3 turn{0};
    double largest_rad = 0;
    double sum_rad = 0;
    double moment = 0;
    for (std::size_t i = 0; i < contacts_.size(); ++i) {
        const glm::dvec3 in = glm::normalize(point(i + 1) - point(i));
        const glm::dvec3 out = glm::normalize(point(i + 2) - point(i + 1));
        const glm::dvec3 across = glm::cross(in, out);
        const double sine = glm::length(across);
        const double angle_rad = std::atan2(sine, glm::dot(in, out));
        if (sine > 0) turn += angle_rad / sine * across;
        largest_rad = std::max(largest_rad, angle_rad);
        sum_rad += angle_rad;
        moment += angle_rad * contacts_[i].before_m;
    }
    const double turn_rad = std::min(std::numbers::pi, std::max(largest_rad, glm::length(turn)));
    const double middle_m = sum_rad > 0 ? moment / sum_rad : 0.5 * length_m_;
    const ScreenPoints at(
        turn_rad, {.radius_m = std::max(middle_m, WedgeIntegral::kLeastRadius_m)},
        {.radius_m = std::max(length_m_ - middle_m, WedgeIntegral::kLeastRadius_m)});
    ComplexBands field = integral.field({}, at.source, at.receiver).total();
    divide_by_free_field(at.source, at.receiver, 0, integral, field);
    return field;
}

/// The share of the field that remains near the limits of the model: towards the longest detours,
/// and where two edges come together that do not bound one narrow face.
double EdgeChain::share() const {
    double share = limits::before_limit(length_m_ - glm::distance(source_, listener_),
                                        limits::kLongestDetour_m);
    for (const Bend& bend : bends_) {
        if (bend.turn_rad < 0)
            share *= limits::before_limit(bend.beyond_m, limits::kLongestLitBend_m);
        if (bend.is_curved) share *= limits::before_limit(bend.turn_rad, std::numbers::pi);
    }
    for (std::size_t i = 0; i + 1 < contacts_.size(); ++i) {
        const Contact& here = contacts_[i];
        const Contact& next = contacts_[i + 1];
        const bool is_narrow_face =
            here.shares_next && std::abs(glm::dot(here.edge->axis, next.edge->axis)) > kAlongFace;
        if (!is_narrow_face)
            share *= std::min(1.0, (next.before_m - here.before_m) / EdgePassage::kNarrow_m);
    }
    return share;
}

/// The product of 1 / (1 + m) over the faces that bends share. Where the edges of a face have
/// different materials, `toward_last` is the weight of the second edge's.
std::array<double, kBandCount> EdgeChain::shared_once(const RayScene& scene,
                                                      double toward_last) const {
    std::array<double, kBandCount> once;
    once.fill(1);
    const auto material = [&](const Contact& contact, double angle_rad) -> const Material& {
        const std::size_t face = angle_rad < contact.edge->open_angle_rad / 2 ? 0 : 1;
        return scene.material(scene.triangle(contact.edge->triangles[face]));
    };
    for (std::size_t i = 0; i + 1 < bends_.size(); ++i) {
        const Contact& here = contacts_[bends_[i].last];
        if (!here.shares_next) continue;
        const Contact& next = contacts_[bends_[i].last + 1];
        const Material& first = material(here, here.out_rad);
        const Material& last = material(next, next.in_rad);
        for (std::size_t b = 0; b < kBandCount; ++b) {
            once[b] *= std::pow(1 + mirrored_pressure(first, b), toward_last - 1) *
                       std::pow(1 + mirrored_pressure(last, b), -toward_last);
        }
    }
    return once;
}

/// With T the fields of the bends relative to free field, and L the length,
///
///     |H| = min(|prod T| F, |prod T'| F, |T_thin|) / L,    F = prod 1 / (1 + m) over shared faces.
///
/// T has the length from the source before a bend and the segment to the next bend after it; T' the
/// same from the listener. Both products tend to that of the geometrical theory of diffraction, and
/// the smaller one has the smaller error at low frequencies. Along a face that reflects the share m
/// of the pressure, incident and reflected sound coincide: F counts them once, so that the chain
/// jumps by the field over the other bends as one of them vanishes. The phase is the mean of both;
/// where they are nearly opposite there is none, and the chain fades out.
/// Where the first or last bend vanishes, the path without it appears, with the fields of the other
/// bends in T or T': that product alone then counts.
ComplexBands EdgeChain::field_of_side(const WedgeIntegral& integral, const RayScene& scene,
                                      const Bands& attenuation_per_m) const {
    ComplexBands ahead;
    ComplexBands back;
    ahead.fill(1);
    back.fill(1);
    double least_bend_rad = std::numbers::pi;
    for (std::size_t i = 0; i < bends_.size(); ++i) {
        const Bend& bend = bends_[i];
        const double last_m = i > 0 ? bends_[i - 1].middle_m : 0;
        const double next_m = i + 1 < bends_.size() ? bends_[i + 1].middle_m : length_m_;
        const ComplexBands t = factor(bend, bend.middle_m, next_m - bend.middle_m, integral, scene);
        const ComplexBands u =
            factor(bend, bend.middle_m - last_m, length_m_ - bend.middle_m, integral, scene);
        for (std::size_t b = 0; b < kBandCount; ++b) {
            ahead[b] *= t[b];
            back[b] *= u[b];
        }
        least_bend_rad = std::min(least_bend_rad, bend.turn_rad);
    }
    const double limit =
        bends_.size() > 1 ? smooth_step(least_bend_rad / limits::kSharpBend_rad) : 0;
    const ComplexBands thin = limit > 0 ? thin_screen(integral) : ComplexBands{};
    const auto straightness = [](const Bend& bend) {
        return 1 - smooth_step(std::abs(bend.turn_rad) / limits::kSharpBend_rad);
    };
    const double straight_first = straightness(bends_.front());
    const double straight_last = straightness(bends_.back());
    const double remaining = share();
    const double toward_back = 0.5 * (1 + straight_last - straight_first);
    const std::array<double, kBandCount> once = shared_once(scene, toward_back);
    ComplexBands field;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        if (ahead[b] == 0.0) continue;
        const std::complex<double> ratio = back[b] / ahead[b];
        const std::complex<double> both = ahead[b] * std::pow(ratio, toward_back);
        const double agreement =
            smooth_step((std::numbers::pi - std::abs(std::arg(ratio))) / kOppositePhases_rad);
        const double least = std::min(std::abs(ahead[b]), std::abs(back[b]));
        double magnitude = once[b] * (least + straight_first * (std::abs(ahead[b]) - least) +
                                      straight_last * (std::abs(back[b]) - least));
        magnitude -= limit * std::max(0.0, magnitude - std::abs(thin[b]));
        const double phase = std::arg(both) - integral.wave_number_per_m(b) * length_m_;
        field[b] = std::polar(agreement * remaining * air_loss(length_m_, attenuation_per_m, b) *
                                  magnitude / length_m_,
                              phase);
    }
    return field;
}

ComplexBands EdgeChain::field(const WedgeIntegral& integral, const RayScene& scene,
                              const Bands& attenuation_per_m) const {
    bool has_sides = false;
    for (std::size_t i = 0; i + 1 < contacts_.size(); ++i) has_sides |= is_along_screen(i);
    if (!has_sides) return field_of_side(integral, scene, attenuation_per_m);
    ComplexBands sum{};
    for (const EdgeChain& side : sides()) {
        const ComplexBands field = side.field_of_side(integral, scene, attenuation_per_m);
        for (std::size_t b = 0; b < kBandCount; ++b) sum[b] += field[b];
    }
    return sum;
}

}  // namespace aula
