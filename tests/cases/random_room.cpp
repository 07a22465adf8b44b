#include "tests/cases/random_room.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

#include "engine/base/sampling.h"

namespace aula::test {

namespace {

/// Builds a random room. All numbers come from one stream, which is the same on all systems.
class RoomDrawing {
 public:
    explicit RoomDrawing(std::uint64_t seed) : random_(derive_seed(seed, 42)) {}

    float uniform(float min, float max) { return min + (max - min) * random_.uniform(); }

    /// A material with an absorption about `mean`, which rises or falls over the octaves.
    std::uint32_t material(float mean, float scattering) {
        const float tilt = uniform(-0.35F, 0.35F);
        Material material;
        material.name = "m" + std::to_string(scene_.materials.size());
        for (std::size_t b = 0; b < kBandCount; ++b) {
            const float x = (static_cast<float>(b) - 3.5F) / 3.5F;
            material.absorption[b] = std::clamp(mean * std::exp(2 * tilt * x), 0.005F, 0.95F);
            material.scattering[b] = scattering;
        }
        scene_.materials.push_back(material);
        return static_cast<std::uint32_t>(scene_.materials.size() - 1);
    }

    float log_uniform(float min, float max) { return min * std::pow(max / min, random_.uniform()); }

    void quad(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, std::uint32_t material) {
        const auto first = static_cast<std::uint32_t>(object_.vertices.size());
        for (const Vec3& corner : {a, b, c, d}) object_.vertices.push_back(corner);
        object_.triangles.push_back({first, first + 1, first + 2});
        object_.triangles.push_back({first, first + 2, first + 3});
        object_.triangle_materials.insert(object_.triangle_materials.end(), 2, material);
    }

    void triangle(const Vec3& a, const Vec3& b, const Vec3& c, std::uint32_t material) {
        const auto first = static_cast<std::uint32_t>(object_.vertices.size());
        for (const Vec3& corner : {a, b, c}) object_.vertices.push_back(corner);
        object_.triangles.push_back({first, first + 1, first + 2});
        object_.triangle_materials.push_back(material);
    }

    /// The faces of a box, except that at its highest x if `open`.
    void box(const Vec3& low, const Vec3& high, const std::array<std::uint32_t, 6>& materials,
             bool open_low = false, bool open_high = false) {
        const auto at = [&](int x, int y, int z) {
            return Vec3(x ? high.x : low.x, y ? high.y : low.y, z ? high.z : low.z);
        };
        if (!open_low) quad(at(0, 0, 0), at(0, 1, 0), at(0, 1, 1), at(0, 0, 1), materials[0]);
        if (!open_high) quad(at(1, 0, 0), at(1, 0, 1), at(1, 1, 1), at(1, 1, 0), materials[1]);
        quad(at(0, 0, 0), at(0, 0, 1), at(1, 0, 1), at(1, 0, 0), materials[2]);
        quad(at(0, 1, 0), at(1, 1, 0), at(1, 1, 1), at(0, 1, 1), materials[3]);
        quad(at(0, 0, 0), at(1, 0, 0), at(1, 1, 0), at(0, 1, 0), materials[4]);
        quad(at(0, 0, 1), at(0, 1, 1), at(1, 1, 1), at(1, 0, 1), materials[5]);
    }

    std::array<std::uint32_t, 6> walls(float absorption, float scattering) {
        std::array<std::uint32_t, 6> of_faces{};
        for (std::uint32_t& face : of_faces)
            face = material(absorption * log_uniform(0.5F, 2), scattering);
        return of_faces;
    }

    Vec3 within(const Vec3& low, const Vec3& high) {
        const Vec3 u(uniform(0.1F, 0.9F), uniform(0.1F, 0.9F), uniform(0.25F, 0.75F));
        return low + u * (high - low);
    }

    Scene take(const Vec3& source, const Vec3& listener) {
        scene_.objects = {object_};
        Source impulse;
        impulse.name = "source";
        impulse.position = source;
        impulse.signal = Source::Signal::impulse;
        impulse.loop = false;
        scene_.sources = {impulse};
        scene_.listener.pose.position = listener;
        return scene_;
    }

 private:
    RandomStream random_;
    Scene scene_;
    Object object_;
};

Scene box_room(RoomDrawing& draw) {
    const Vec3 size(draw.log_uniform(3, 20), draw.log_uniform(3, 15), draw.uniform(2.4F, 8));
    draw.box(Vec3(0), size, draw.walls(draw.log_uniform(0.05F, 0.5F), draw.uniform(0.05F, 0.7F)));
    return draw.take(draw.within(Vec3(0), size), draw.within(Vec3(0), size));
}

Scene coupled_rooms(RoomDrawing& draw) {
    const float height = draw.uniform(2.5F, 6);
    const float depth = draw.log_uniform(3, 10);
    const float middle = draw.log_uniform(3, 10);
    const Vec3 end(middle + draw.log_uniform(3, 10), depth, height);
    const float scattering = draw.uniform(0.1F, 0.6F);
    const Vec3 first_end(middle, depth, height);
    draw.box(Vec3(0), first_end, draw.walls(draw.log_uniform(0.05F, 0.5F), scattering), false,
             true);
    draw.box(Vec3(middle, 0, 0), end, draw.walls(draw.log_uniform(0.05F, 0.5F), scattering), true);
    // The wall between the rooms, with an opening.
    const auto wall = draw.material(draw.log_uniform(0.05F, 0.3F), scattering);
    const float left = draw.uniform(0.2F, 0.4F) * depth;
    const float right = left + draw.uniform(0.2F, 0.5F) * depth;
    const float top = draw.uniform(0.5F, 0.8F) * height;
    const auto face = [&](float y0, float y1, float z0, float z1) {
        draw.quad({middle, y0, z0}, {middle, y1, z0}, {middle, y1, z1}, {middle, y0, z1}, wall);
    };
    face(0, left, 0, height);
    face(right, depth, 0, height);
    face(left, right, top, height);
    const bool same_room = draw.uniform(0, 1) < 0.4F;
    const Vec3 source = draw.within(Vec3(0), first_end);
    const Vec3 listener =
        draw.within(same_room ? Vec3(0) : Vec3(middle, 0, 0), same_room ? first_end : end);
    return draw.take(source, listener);
}

Scene hall(RoomDrawing& draw) {
    const Vec3 size(draw.log_uniform(6, 30), draw.log_uniform(5, 20), draw.uniform(2.8F, 9));
    auto walls = draw.walls(draw.log_uniform(0.03F, 0.15F), draw.uniform(0.05F, 0.4F));
    const float planes = draw.uniform(0, 3);
    const float scattering = draw.uniform(0.1F, 0.5F);
    if (planes < 2) walls[5] = draw.material(draw.uniform(0.5F, 0.9F), scattering);
    if (planes > 1) walls[4] = draw.material(draw.uniform(0.3F, 0.8F), scattering);
    draw.box(Vec3(0), size, walls);
    return draw.take(draw.within(Vec3(0), size), draw.within(Vec3(0), size));
}

Scene prism(RoomDrawing& draw) {
    const int corners = 5 + static_cast<int>(draw.uniform(0, 5));
    const float radius = draw.log_uniform(3, 12);
    const float height = draw.uniform(2.5F, 8);
    const float absorption = draw.log_uniform(0.05F, 0.4F);
    const float scattering = draw.uniform(0.1F, 0.6F);
    std::vector<Vec3> ring;
    for (int i = 0; i < corners; ++i) {
        const float angle =
            2 * std::numbers::pi_v<float> * static_cast<float>(i) / static_cast<float>(corners);
        const float r = radius * draw.uniform(0.7F, 1.3F);
        ring.emplace_back(r * std::cos(angle), r * std::sin(angle), 0);
    }
    const auto floor = draw.material(absorption * draw.log_uniform(0.5F, 2), scattering);
    const auto ceiling = draw.material(absorption * draw.log_uniform(0.5F, 2), scattering);
    const Vec3 up(0, 0, height);
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const Vec3& a = ring[i];
        const Vec3& b = ring[(i + 1) % ring.size()];
        draw.triangle(Vec3(0), a, b, floor);
        draw.triangle(up, b + up, a + up, ceiling);
        draw.quad(a, a + up, b + up, b,
                  draw.material(absorption * draw.log_uniform(0.5F, 2), scattering));
    }
    const float thick = 0.08F * radius;
    draw.box({-thick, -thick, 0}, {thick, thick, height}, draw.walls(absorption, scattering));
    // Between the pillar and the nearest a corner may be: 0.7 cos(36 degrees) of the radius.
    const auto place = [&] {
        const float angle = draw.uniform(0, 2 * std::numbers::pi_v<float>);
        const float r = draw.uniform(0.2F, 0.5F) * radius;
        return Vec3(r * std::cos(angle), r * std::sin(angle), draw.uniform(0.3F, 0.7F) * height);
    };
    const Vec3 source = place();
    return draw.take(source, place());
}

}  // namespace

Scene random_room(std::uint64_t seed) {
    RoomDrawing draw(seed);
    switch (seed % 4) {
        case 0:
            return box_room(draw);
        case 1:
            return coupled_rooms(draw);
        case 2:
            return hall(draw);
        default:
            return prism(draw);
    }
}

}  // namespace aula::test
