#include "apps/room/images/box_images.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <numbers>
#include <span>
#include <type_traits>
#include <utility>

#include "apps/room/images/pulse_filter.h"
#include "engine/base/spherical_harmonics.h"
#include "process/multiversion.h"

namespace aula {

namespace {

Bands bands_of(float value) { return Bands::filled(value); }
Bands bands_of(const Bands& value) { return value; }

/// The lengths of paths to the images of a row, from the squares of their offsets across the row
/// and along it, and the loss of their fluence or pressure by distance.
AULA_MULTIVERSION void spread_row(double across2, std::span<const double> along2, bool is_pressure,
                                  double* lengths_m, double* spread) {
    for (std::size_t k = 0; k < along2.size(); ++k) {
        const double length_m = std::max(std::sqrt(across2 + along2[k]), 1e-3);
        lengths_m[k] = length_m;
        spread[k] = 1 / length_m;
    }
    if (is_pressure) return;
    for (std::size_t k = 0; k < along2.size(); ++k) spread[k] *= spread[k] / (4 * std::numbers::pi);
}

/// The loss in air over a length, as the product of two table values. The steps of the finer table
/// change a value by at most 0.05 dB at 8 kHz.
class AirLoss {
 public:
    AirLoss(const Bands& per_m, double reach_m) {
        const auto loss = [&](double length_m) {
            Bands b;
            for (std::size_t i = 0; i < kBandCount; ++i)
                b[i] = static_cast<float>(std::exp(-double{per_m[i]} * length_m));
            return b;
        };
        for (int metre = 0; metre <= static_cast<int>(reach_m) + 1; ++metre)
            metres_.push_back(loss(metre));
        for (int step = 0; step < kSteps; ++step) parts_.push_back(loss((step + 0.5) / kSteps));
    }
    Bands operator()(double length_m) const {
        const auto metre = static_cast<std::size_t>(length_m);
        const auto part =
            static_cast<std::size_t>((length_m - static_cast<double>(metre)) * kSteps);
        return metres_[metre] * parts_[part];
    }

 private:
    static constexpr int kSteps = 16;
    std::vector<Bands> metres_, parts_;
};

/// The side of a box that a triangle lies in: its axis, and 0 for the low, 1 for the high one.
std::optional<std::pair<std::size_t, std::size_t>> side_of(const std::array<Vec3, 3>& corners,
                                                           const Bounds& box) {
    for (int axis = 0; axis < 3; ++axis) {
        const auto lies_at = [&](float x) {
            return std::all_of(corners.begin(), corners.end(),
                               [&](const Vec3& v) { return v[axis] == x; });
        };
        if (lies_at(box.min[axis])) return std::pair(std::size_t(axis), std::size_t{0});
        if (lies_at(box.max[axis])) return std::pair(std::size_t(axis), std::size_t{1});
    }
    return std::nullopt;
}

bool is_corner(const Vec3& v, const Bounds& box) {
    for (int axis = 0; axis < 3; ++axis)
        if (v[axis] != box.min[axis] && v[axis] != box.max[axis]) return false;
    return true;
}

struct BoxWalls {
    Bounds bounds;
    std::array<std::array<const Material*, 2>, 3> materials{};  ///< [axis][low, high]
};

/// The walls of an object that is a box of 12 triangles; each wall has one material.
std::optional<BoxWalls> walls_of(const Scene& scene) {
    if (scene.objects.size() != 1 || scene.objects[0].moves() ||
        scene.objects[0].triangles.size() != 12)
        return std::nullopt;
    const Object& object = scene.objects[0];
    const std::vector<Vec3> vertices = object.world_vertices(0.0);
    BoxWalls walls;
    walls.bounds.add(vertices);
    std::array<std::array<float, 2>, 3> areas{};
    std::array<std::array<Vec3, 2>, 3> sums{};  // of the corners: other triangles, other sums
    for (std::size_t t = 0; t < 12; ++t) {
        std::array<Vec3, 3> corners{};
        for (std::size_t i = 0; i < 3; ++i) corners[i] = vertices[object.triangles[t][i]];
        const auto side = side_of(corners, walls.bounds);
        if (!side || !std::all_of(corners.begin(), corners.end(),
                                  [&](const Vec3& v) { return is_corner(v, walls.bounds); }))
            return std::nullopt;
        const auto [axis, high] = *side;
        const Material* const material = &scene.materials[object.triangle_materials[t]];
        const Vec3 sum = corners[0] + corners[1] + corners[2];
        const float area =
            glm::length(glm::cross(corners[1] - corners[0], corners[2] - corners[0])) / 2;
        const Material*& known = walls.materials[axis][high];
        if (known != nullptr && (known != material || sums[axis][high] == sum)) return std::nullopt;
        known = material;
        sums[axis][high] = sum;
        areas[axis][high] += area;
    }
    const Vec3 size = walls.bounds.max - walls.bounds.min;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const float area =
            size[static_cast<int>((axis + 1) % 3)] * size[static_cast<int>((axis + 2) % 3)];
        for (const float found : areas[axis])
            if (!(std::abs(found - area) <= 1e-4F * area)) return std::nullopt;
    }
    return walls;
}

bool asks_for_all_paths(const Simulation& s) {
    return s.estimator == Estimator::patch && s.order == 0 && s.specular && s.direct;
}

/// Different for all images, and 0 for the direct sound.
std::uint64_t key_of(const std::array<int, 3>& index) {
    std::uint64_t key = 0;
    for (const int i : index)  // kMostImages bounds them
        key = key << 21 | static_cast<std::uint64_t>(i >= 0 ? 2 * i : -2 * i - 1);
    return key;
}

bool is_inside(const Vec3& p, const Bounds& box) {
    constexpr float kOff_m = 1e-3F;  // positions on surfaces are moved off them by rays
    for (int axis = 0; axis < 3; ++axis)
        if (!(p[axis] > box.min[axis] + kOff_m && p[axis] < box.max[axis] - kOff_m)) return false;
    return true;
}

}  // namespace

std::optional<BoxImages> BoxImages::find(const Scene& scene, std::span<const Pose> receivers,
                                         double length_s) {
    if (!asks_for_all_paths(scene.simulation)) return std::nullopt;
    const std::optional<BoxWalls> walls = walls_of(scene);
    if (!walls) return std::nullopt;
    BoxImages images;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t high = 0; high < 2; ++high) {
            const Material& material = *walls->materials[axis][high];
            if (material.scattering.max() > 0 || material.sound_reduction_db) return std::nullopt;
            images.reflected_[axis][high] = complement(material.absorption);
        }
    }
    for (const Pose& receiver : receivers) images.receivers_.push_back(receiver.position);
    images.sources_ = scene.sources;
    const auto inside = [&](const Vec3& p) { return is_inside(p, walls->bounds); };
    if (!std::all_of(images.receivers_.begin(), images.receivers_.end(), inside) ||
        !std::all_of(scene.sources.begin(), scene.sources.end(),
                     [&](const Source& source) { return inside(source.position_at(0)); }))
        return std::nullopt;
    images.low_ = walls->bounds.min;
    images.high_ = walls->bounds.max;
    images.attenuation_per_m_ = scene.medium.attenuation_per_m();
    images.speed_m_s_ = scene.medium.speed_of_sound_m_s();
    images.path_order_ = scene.simulation.specular_order;
    images.length_s_ = TimeBins(length_s).length_s();
    const Vec3 size = images.high_ - images.low_;
    const double reach_m = images.length_s_ * double{images.speed_m_s_};
    const double of_pair = 4.0 / 3 * std::numbers::pi * std::pow(reach_m, 3) /
                           (double{size.x} * double{size.y} * double{size.z});
    const auto pairs = static_cast<double>(receivers.size() * scene.sources.size());
    if (of_pair > kMostImages && of_pair * pairs > kMostOfAllPairs) return std::nullopt;
    return images;
}

template <typename Value>
Vec3 BoxImages::Image<Value>::direction() const {
    const double scale = 1 / std::max(length_m, 0.1);
    return {offset_m[0] * scale, offset_m[1] * scale, offset_m[2] * scale};
}

template <typename Value>
Vec3 BoxImages::Image<Value>::departure() const {
    const Vec3 to = direction();
    Vec3 from = -to;
    for (int axis = 0; axis < 3; ++axis)
        if (index[static_cast<std::size_t>(axis)] % 2 != 0) from[axis] = to[axis];
    return from;
}

template <typename Value>
BoxImages::Image<Value> BoxImages::Row<Value>::image(std::size_t k) const {
    Image<Value> image;
    image.order = order() + std::abs(zs[k].index);
    image.length_m = lengths_m[k];
    image.offset_m = {x.offset_m, y.offset_m, zs[k].offset_m};
    image.index = {x.index, y.index, zs[k].index};
    image.value = x.value * y.value * zs[k].value * static_cast<float>(spread[k]);
    return image;
}

/// By ascending distance along the axis.
template <typename Value>
std::vector<BoxImages::AxisImage<Value>> BoxImages::along(std::size_t axis, const Vec3& source,
                                                          const Vec3& receiver,
                                                          bool is_pressure) const {
    const auto a = static_cast<int>(axis);
    const double low = double{low_[a]};
    const double size = double{high_[a]} - low;
    const double place = double{source[a]} - low;
    const double seen_from = double{receiver[a]} - low;
    const double reach_m = length_s_ * double{speed_m_s_};
    const auto most = static_cast<int>(std::ceil(reach_m / size)) + 1;
    std::vector<AxisImage<Value>> images;
    for (int index = -most; index <= most; ++index) {
        // Image 1 is behind the high wall, -1 behind the low one; odd ones are mirrored.
        const double at = index % 2 == 0 ? index * size + place : (index + 1) * size - place;
        if (std::abs(at - seen_from) > reach_m) continue;
        const int walls = std::abs(index);
        const int high = index > 0 ? (walls + 1) / 2 : walls / 2;
        Bands value;
        for (std::size_t b = 0; b < kBandCount; ++b) {
            const double energy = std::pow(double{reflected_[axis][0][b]}, walls - high) *
                                  std::pow(double{reflected_[axis][1][b]}, high);
            value[b] = static_cast<float>(is_pressure ? std::sqrt(energy) : energy);
        }
        if constexpr (std::is_same_v<Value, float>)
            images.push_back({at - seen_from, index, value[0]});
        else
            images.push_back({at - seen_from, index, value});
    }
    std::sort(images.begin(), images.end(), [](const auto& p, const auto& q) {
        return std::abs(p.offset_m) < std::abs(q.offset_m);
    });
    return images;
}

/// Calls each(row) for all images of a pair, with the fluence or the pressure as the value.
template <typename Value, typename Each>
void BoxImages::visit_rows(std::size_t source, std::size_t receiver, bool is_pressure,
                           const Each& each) const {
    const Vec3 place = sources_[source].position_at(0);
    const Vec3& at = receivers_[receiver];
    const double reach_m = length_s_ * double{speed_m_s_};
    const auto xs = along<Value>(0, place, at, is_pressure);
    const auto ys = along<Value>(1, place, at, is_pressure);
    const auto zs = along<Value>(2, place, at, is_pressure);
    std::vector<double> z2, lengths_m(zs.size()), spread(zs.size());
    for (const auto& z : zs) z2.push_back(z.offset_m * z.offset_m);
    for (const auto& x : xs) {
        std::size_t count = zs.size();
        for (const auto& y : ys) {
            const double xy2 = x.offset_m * x.offset_m + y.offset_m * y.offset_m;
            while (count > 0 && xy2 + z2[count - 1] > reach_m * reach_m) --count;
            if (count == 0) break;
            best_version<spread_row>(xy2, std::span<const double>(z2).first(count), is_pressure,
                                     lengths_m.data(), spread.data());
            each(Row<Value>{x, y, std::span(zs).first(count), lengths_m, spread});
        }
    }
}

/// Calls each(image) for all images.
template <typename Value, typename Each>
void BoxImages::visit(std::size_t source, std::size_t receiver, bool is_pressure,
                      const Each& each) const {
    const Source& from = sources_[source];
    const glm::mat3 rotation = from.pose_at(0).rotation();
    const AirLoss air(attenuation_per_m_ * (is_pressure ? 0.5F : 1.0F),
                      length_s_ * double{speed_m_s_});
    const bool is_directional = !from.directivity.is_omnidirectional();
    visit_rows<Value>(source, receiver, is_pressure, [&](const Row<Value>& row) {
        for (std::size_t k = 0; k < row.zs.size(); ++k) {
            Image<Value> image = row.image(k);
            if constexpr (std::is_same_v<Value, Bands>) {
                image.value *= air(image.length_m);
                if (is_directional) {
                    Bands factor = from.directivity.factor(image.departure() * rotation);
                    for (float& f : factor.value) f = is_pressure ? std::sqrt(f) : f;
                    image.value *= factor;
                }
            }
            each(image);
        }
    });
}

/// True if all octaves of all images have equal gains.
bool BoxImages::is_flat(std::size_t source) const {
    bool flat = attenuation_per_m_ == Bands{} && sources_[source].directivity.is_omnidirectional();
    for (const auto& walls : reflected_)
        for (const Bands& b : walls) flat = flat && b == Bands::filled(b[0]);
    return flat;
}

template <typename Value>
SoundPath BoxImages::path_of(const Image<Value>& image) const {
    SoundPath path;
    path.kind = image.order == 0 ? SoundPath::Kind::direct : SoundPath::Kind::image;
    path.order = image.order;
    path.length_m = static_cast<float>(image.length_m);
    path.direction = image.direction();
    path.departure = image.departure();
    path.energy = bands_of(image.value);
    path.key = key_of(image.index);
    path.is_main = image.order == 0;
    return path;
}

void BoxImages::add_bins(std::size_t source, std::size_t receiver, EnergyResponse& response) const {
    visit<Bands>(source, receiver, false, [&](const Image<Bands>& image) {
        if (image.order <= path_order_)
            response.paths.push_back(path_of(image));
        else
            response.add(image.length_m, image.value,
                         DirectionMoments::of(image.direction()) * image.value.sum());
    });
}

/// The same for equal octaves: energies and directions are summed in milliseconds, of which all
/// bins consist.
void BoxImages::add_flat_bins(std::size_t source, std::size_t receiver,
                              EnergyResponse& response) const {
    const double ms_per_m = 1000 / double{speed_m_s_};
    std::vector<std::array<double, 9>> sums(static_cast<std::size_t>(length_s_ * 1000) + 2);
    visit_rows<float>(source, receiver, false, [&](const Row<float>& row) {
        const double x_m = row.x.offset_m, y_m = row.y.offset_m;
        const double of_row{row.x.value * row.y.value};
        for (std::size_t k = 0; k < row.zs.size(); ++k) {
            const auto& z = row.zs[k];
            if (row.order() <= path_order_ && row.order() + std::abs(z.index) <= path_order_) {
                response.paths.push_back(path_of(row.image(k)));
                continue;
            }
            const double length_m = row.lengths_m[k];
            const double energy = of_row * double{z.value} * row.spread[k];
            const double per_m = energy / std::max(length_m, 0.1);
            const double per_m2 = per_m / std::max(length_m, 0.1);
            std::array<double, 9>& sum = sums[static_cast<std::size_t>(length_m * ms_per_m)];
            sum[0] += energy;
            sum[1] += per_m * x_m;
            sum[2] += per_m * y_m;
            sum[3] += per_m * z.offset_m;
            sum[4] += per_m2 * x_m * x_m;
            sum[5] += per_m2 * y_m * y_m;
            sum[6] += per_m2 * x_m * y_m;
            sum[7] += per_m2 * y_m * z.offset_m;
            sum[8] += per_m2 * z.offset_m * x_m;
        }
    });
    for (std::size_t ms = 0; ms < sums.size(); ++ms) {
        const auto [energy, x, y, z, xx, yy, xy, yz, zx] = sums[ms];
        const DirectionMoments directions{Vec3(x, y, z),
                                          static_cast<float>(xx - energy / 3),
                                          static_cast<float>(yy - energy / 3),
                                          static_cast<float>(xy),
                                          static_cast<float>(yz),
                                          static_cast<float>(zx)};
        response.add((static_cast<double>(ms) + 0.5) / ms_per_m,
                     Bands::filled(static_cast<float>(energy)),
                     directions * static_cast<float>(kBandCount));
    }
}

EnergyResponse BoxImages::response(std::size_t source, std::size_t receiver) const {
    EnergyResponse response = EnergyResponse::silent(TimeBins(length_s_), speed_m_s_);
    if (is_flat(source))
        add_flat_bins(source, receiver, response);
    else
        add_bins(source, receiver, response);
    std::sort(response.paths.begin(), response.paths.end(),
              [](const SoundPath& p, const SoundPath& q) { return p.length_m < q.length_m; });
    return response;
}

/// All images of equal octaves in an omnidirectional channel.
std::vector<float> BoxImages::flat_pressure(std::size_t source, std::size_t receiver,
                                            double sample_rate_hz, std::size_t samples) const {
    const double finer_per_m = sample_rate_hz * kFiner / double{speed_m_s_};
    const double reach = length_s_ * sample_rate_hz * kFiner;
    std::vector<float> finer(std::max(static_cast<std::size_t>(reach) + 2, samples * kFiner) +
                             kPulseTaps * kFiner);
    float* const begin = finer.data() + kPulseTaps * kFiner / 2;
    visit_rows<float>(source, receiver, true, [&](const Row<float>& row) {
        const float of_row = row.x.value * row.y.value;
        for (std::size_t k = 0; k < row.zs.size(); ++k) {
            const double at = row.lengths_m[k] * finer_per_m;
            const auto before = static_cast<std::int32_t>(at);
            const auto share = static_cast<float>(at - static_cast<double>(before));
            const float value = of_row * row.zs[k].value * static_cast<float>(row.spread[k]);
            begin[before] += value * (1 - share);
            begin[before + 1] += value * share;
        }
    });
    return coarser(finer, samples);
}

template <typename Value>
std::vector<std::vector<float>> BoxImages::pressure_of(std::size_t source, std::size_t receiver,
                                                       double sample_rate_hz, std::size_t samples,
                                                       int ambisonic_order, bool with_paths) const {
    const auto channels = static_cast<std::size_t>((ambisonic_order + 1) * (ambisonic_order + 1));
    const double finer_per_m = sample_rate_hz * kFiner / double{speed_m_s_};
    std::vector<std::vector<Value>> finer(
        channels, std::vector<Value>((samples + kPulseTaps) * kFiner, Value{}));
    std::vector<double> harmonics(channels, 1);
    visit<Value>(source, receiver, true, [&](const Image<Value>& image) {
        if (!with_paths && image.order <= path_order_) return;
        const double at = image.length_m * finer_per_m;
        const auto before = static_cast<std::size_t>(at);
        if (before >= samples * kFiner) return;
        const auto share = static_cast<float>(at - static_cast<double>(before));
        if (ambisonic_order > 0)
            spherical_harmonics(image.direction(), ambisonic_order, harmonics.data());
        for (std::size_t c = 0; c < channels; ++c) {
            const Value scaled = image.value * static_cast<float>(harmonics[c]);
            Value* const to = finer[c].data() + before + kPulseTaps * kFiner / 2;
            to[0] += scaled * (1 - share);
            to[1] += scaled * share;
        }
    });
    std::vector<std::vector<float>> result;
    for (const std::vector<Value>& channel : finer) {
        std::vector<Value> filtered = coarser(channel, samples);
        if constexpr (std::is_same_v<Value, float>)
            result.push_back(std::move(filtered));
        else
            result.push_back(joined(filtered, sample_rate_hz));
    }
    return result;
}

std::vector<std::vector<float>> BoxImages::pressure(std::size_t source, std::size_t receiver,
                                                    double sample_rate_hz, std::size_t samples,
                                                    int ambisonic_order, bool with_paths) const {
    if (is_flat(source) && ambisonic_order == 0 && with_paths)
        return {flat_pressure(source, receiver, sample_rate_hz, samples)};
    return is_flat(source) ? pressure_of<float>(source, receiver, sample_rate_hz, samples,
                                                ambisonic_order, with_paths)
                           : pressure_of<Bands>(source, receiver, sample_rate_hz, samples,
                                                ambisonic_order, with_paths);
}

}  // namespace aula
