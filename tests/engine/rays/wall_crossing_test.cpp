// Walls that transmit: single faces, pairs of faces, and the direct sound through them.

#include "engine/rays/wall_crossing.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "tests/support/rooms.h"

using namespace aula;

namespace {

/// A scene of walls that are squares across x; each is one face of a material.
class Walls {
 public:
    /// Adds a material; returns its index.
    std::uint32_t material(std::optional<float> reduction_db, float scattering = 0) {
        Material material{"", Bands::filled(1), Bands::filled(scattering)};
        if (reduction_db) material.sound_reduction_db = Bands::filled(*reduction_db);
        scene_.materials.push_back(material);
        return static_cast<std::uint32_t>(scene_.materials.size()) - 1;
    }

    /// Adds a face at x, from y = `from_y_m` on, turned about z.
    void face(float x_m, std::uint32_t material, float from_y_m = -20, float turn_rad = 0) {
        Object object;
        const float c = std::cos(turn_rad), s = std::sin(turn_rad);
        for (const auto& [y, z] :
             {std::pair(from_y_m, -20.F), {20.F, -20.F}, {20.F, 20.F}, {from_y_m, 20.F}}) {
            object.vertices.emplace_back(x_m - s * y, c * y, z);
        }
        object.triangles = {{0, 1, 2}, {0, 2, 3}};
        object.triangle_materials = {material, material};
        scene_.objects.push_back(object);
    }

    /// The share that passes from x = -4 to x = 4 in the first band.
    double share(float y_m = 0) const {
        const RayScene rays(scene_);
        const double there =
            double{share_through_walls(rays, Vec3(-4, y_m, 0), Vec3(4, y_m, 0.1F))[0]};
        const double back =
            double{share_through_walls(rays, Vec3(4, y_m, 0.1F), Vec3(-4, y_m, 0))[0]};
        CHECK(there == Approx(back).epsilon(1e-5));  // sums of 128 roundings
        return there;
    }

    const Scene& scene() const { return scene_; }

 private:
    Scene scene_;
};

/// Where sound that enters the first wall on a line leaves it.
WallExit exit_of(const RayScene& rays, const Vec3& from, const Vec3& direction) {
    std::vector<Hit> hits(1);
    const Ray ray{from, glm::normalize(direction)};
    rays.intersect({&ray, 1}, hits);
    const Vec3 normal = rays.facing_normal(hits[0], ray.direction);
    const RayScene::PointOff at =
        RayScene::point_beyond(hits[0].distance_m, -glm::dot(ray.direction, normal));
    const WallEntry entry{hits[0], from + at.along_m * ray.direction + at.off_m * normal, normal};
    std::vector<WallExit> exits;
    find_wall_exits(rays, {&entry, 1}, exits);
    return exits.at(0);
}

double db(double reduction_db) { return std::pow(10, -reduction_db / 10); }

/// Products of a few numbers, and a sum of 128, in single precision.
constexpr double kRounding = 1e-5;

}  // namespace

TEST_CASE("a wall transmits the direct sound with its sound reduction, two walls with both") {
    Walls one;
    one.face(0, one.material(20));
    CHECK(one.share() == Approx(db(20)).epsilon(kRounding));
    Walls two;
    two.face(-1, two.material(20));
    two.face(1, two.material(15));
    CHECK(two.share() == Approx(db(35)).epsilon(kRounding));
    Walls scattering;
    scattering.face(0, scattering.material(20, 0.3F));
    CHECK(scattering.share() == Approx(0.7 * db(20)).epsilon(kRounding));
    // Companion: 0.001 dB more.
    Walls other;
    other.face(0, other.material(20.001F));
    CHECK(other.share() != Approx(db(20)).epsilon(kRounding));
    Walls two_others;
    two_others.face(-1, two_others.material(20));
    two_others.face(1, two_others.material(15.001F));
    CHECK(two_others.share() != Approx(db(35)).epsilon(kRounding));
    // The bend of the lines lies in the plane of the wall, or within one of its two faces.
    for (const float x_m : {0.0F, 1e-5F, -1e-4F, 2.0F}) {
        INFO("x = " << x_m);
        Walls anywhere;
        anywhere.face(x_m, anywhere.material(20));
        CHECK(anywhere.share() == Approx(db(20)).epsilon(kRounding));
    }
}

TEST_CASE("a wall that sound passes at grazing incidence counts once") {
    for (const float turn_rad : {1.3F, 1.5F, 1.56F, 1.57F}) {
        Walls walls;
        walls.face(0, walls.material(20), -20, turn_rad);
        CAPTURE(turn_rad);
        CHECK(walls.share() == Approx(db(20)).epsilon(kRounding));
    }
}

TEST_CASE("two faces are one wall if they are near and parallel, and both transmit") {
    const auto pair = [](float gap_m, float turn_rad, float first_db, float second_db) {
        Walls walls;
        walls.face(0, walls.material(first_db));
        walls.face(gap_m, walls.material(second_db), -20, turn_rad);
        return walls.share();
    };
    CHECK(pair(0.2F, 0, 30, 30) == Approx(db(30)).epsilon(kRounding));
    CHECK(pair(0.55F, 0, 30, 25) == Approx(db(30)).epsilon(kRounding));
    // Companion: at 0.7 m, and at 25 degrees, they are two walls.
    CHECK(pair(0.7F, 0, 30, 25) == Approx(db(55)).epsilon(kRounding));
    CHECK(pair(0.45F, 0.1F, 30, 30) == Approx(db(30)).epsilon(kRounding));
    CHECK(pair(0.45F, 0.44F, 30, 30) == Approx(db(60)).epsilon(kRounding));
    // Two walls of two faces each.
    Walls four;
    for (const float x_m : {-1.0F, -0.8F, 1.0F, 1.3F}) four.face(x_m, four.material(20));
    CHECK(four.share() == Approx(db(40)).epsilon(kRounding));
}

TEST_CASE("an opaque wall behind or before one that transmits passes nothing") {
    for (const float x_m : {-2.0F, -0.1F, 0.1F, 2.0F}) {
        Walls walls;
        walls.face(0, walls.material(5));
        CHECK(walls.share() > 0.3);
        walls.face(x_m, walls.material(std::nullopt));
        CHECK(walls.share() == 0);
    }
    Walls none;
    CHECK(none.share() == 0);  // what is free is direct sound
}

TEST_CASE(
    "an opaque face in contact with one that transmits blocks it, a face beside it does not") {
    for (const float gap_m : {0.0F, 1e-5F, 1e-4F, 5e-4F, 1e-3F, 1.9e-3F, 2.1e-3F}) {
        for (const float side : {-1.0F, 1.0F}) {
            CAPTURE(gap_m, side);
            // The listener is 4 m or 100 m away: rounding grows with the length of a ray.
            Walls walls;
            walls.face(0, walls.material(5));
            walls.face(side * gap_m, walls.material(std::nullopt));
            CHECK(walls.share() == 0);
            CHECK(share_through_walls(RayScene(walls.scene()), Vec3(-100, 3, 0), Vec3(4, 0, 0))
                      .max() == 0);
            Walls two_faces;
            two_faces.face(-0.1F, two_faces.material(5));
            two_faces.face(0, two_faces.material(5));
            CHECK(two_faces.share() > 0.3);
            two_faces.face(side * gap_m, two_faces.material(std::nullopt));
            CHECK(two_faces.share() == 0);
            const WallExit exit =
                exit_of(RayScene(two_faces.scene()), Vec3(-4, 0, 0), Vec3(1, 0.2F, 0));
            // An opaque face in front of the far one is met as the next wall.
            if (side > 0 && gap_m > 0 && gap_m < RayScene::kBacking_m)
                CHECK(exit.wall.transmission.max() == 0);
        }
    }
    // In the same plane, from y = 4 m on: the lines of the spindle are within 1 m of y = 0.
    Walls beside;
    beside.face(0, beside.material(5));
    beside.face(0, beside.material(std::nullopt), 4);
    CHECK(beside.share() == Approx(db(5)).epsilon(kRounding));
    // Across it, as the frame of a pane: it covers the lines on one of its sides.
    Walls frame;
    frame.face(0, frame.material(5));
    frame.face(2, frame.material(std::nullopt), -20, 0.5F * std::numbers::pi_v<float>);
    CHECK_FALSE(RayScene(frame.scene()).is_backed(Vec3(0, 1e-4F, 0), 0));
    CHECK(frame.share(0.001F) == Approx(db(5)).epsilon(0.5));
}

TEST_CASE("of coincident faces an opaque one blocks in any order, also when it becomes opaque") {
    for (const bool many : {false, true}) {
        for (const bool opaque_first : {false, true}) {
            CAPTURE(many, opaque_first);
            Walls walls;
            const std::uint32_t glass = walls.material(5);
            const std::uint32_t stone = walls.material(std::nullopt);
            walls.face(0, opaque_first ? stone : glass);
            walls.face(0, opaque_first ? glass : stone);
            // Far away, so that the triangles are too many for the search without a hierarchy.
            for (int i = 0; many && i < 40; ++i) walls.face(1000 + static_cast<float>(i), stone);
            CHECK(walls.share() == 0);
            RayScene rays(walls.scene());
            const auto share = [&] {
                return share_through_walls(rays, Vec3(-4, 0, 0), Vec3(4, 0, 0)).max();
            };
            rays.set_material(opaque_first ? 0 : 1, walls.scene().materials[glass]);
            CHECK(share() > 0.3F);
            rays.set_material(opaque_first ? 1 : 0, walls.scene().materials[stone]);
            CHECK(share() == 0);
        }
    }
}

TEST_CASE("more than 16 faces block the direct sound") {
    const auto faces = [](int count) {
        Walls walls;
        const std::uint32_t material = walls.material(1);
        // Pairs 0.1 m apart.
        for (int i = 0; i < count; ++i) {
            walls.face(-3.5F + 0.9F * static_cast<float>(i / 2) + 0.1F * static_cast<float>(i % 2),
                       material);
        }
        return walls.share();
    };
    CHECK(faces(16) == Approx(db(8)).epsilon(kRounding));
    CHECK(faces(17) == 0);
}

TEST_CASE("the direct sound through a wall fades at its end while a listener walks") {
    Walls walls;
    walls.face(0, walls.material(10), 0);
    const RayScene rays(walls.scene());
    double before = db(10);
    double largest_step = 0;
    double largest_step_of_a_line = 0;
    bool line_before = true;
    for (float y_m = 2; y_m > -2; y_m -= 0.01F) {
        const double now = walls.share(y_m);
        largest_step = std::max(largest_step, std::abs(now - before));
        before = now;
        const bool line = !rays.visible(Vec3(-4, y_m, 0), Vec3(4, y_m, 0));
        if (line != line_before) largest_step_of_a_line = db(10);
        line_before = line;
    }
    CHECK(before == 0);
    // The middle of the spindle is 0.83 m in radius. A strip of 1 cm through its centre holds
    // 16/15 / (pi / 3) 0.01 / 0.83 = 1.2 % of the weights, 1.6 mean lines of 128. The lines lie
    // irregularly: three in one step, each with at most 3 / 128, are allowed.
    CHECK(largest_step < 3 * 3.0 / 128 * db(10));
    // Companion: a single line.
    CHECK(largest_step_of_a_line > 3 * 3.0 / 128 * db(10));
}

TEST_CASE("the path through walls has the length, direction and level of the straight line") {
    Walls walls;
    walls.face(0, walls.material(20));
    const RayScene rays(walls.scene());
    const Bands attenuation = Bands::filled(0.01F);
    const auto path = path_through_walls(rays, Vec3(-4, 0, 0), Vec3(4, 0, 0), attenuation);
    REQUIRE(path);
    CHECK(path->length_m == Approx(8).epsilon(1e-6));
    CHECK(glm::distance(path->direction, Vec3(-1, 0, 0)) < 1e-6F);
    CHECK(path->order == 0);
    CHECK(path->edges == 0);
    CHECK(path->kind == SoundPath::Kind::through_walls);
    CHECK(double{path->energy[2]} ==
          Approx(db(20) * std::exp(-0.08) / (4 * std::numbers::pi * 64)).epsilon(kRounding));
    Walls opaque;
    opaque.face(0, opaque.material(std::nullopt));
    CHECK_FALSE(path_through_walls(RayScene(opaque.scene()), Vec3(-4, 0, 0), Vec3(4, 0, 0), {}));
}

TEST_CASE("sound leaves a wall opposite to where it enters, and comes back to that point") {
    Walls walls;
    walls.face(0, walls.material(20, 0.2F));
    walls.face(0.3F, walls.material(30, 0.1F), -20, 0.1F);
    walls.face(2, walls.material(25));
    const RayScene rays(walls.scene());
    const WallExit there = exit_of(rays, Vec3(-1, 0, 0), Vec3(1, 0.5F, 0));
    CHECK(double{there.wall.transmission[0]} == Approx(db(30)).epsilon(kRounding));
    CHECK(there.wall.scattering[0] == 0.2F);
    // Straight across from (0, 0.5): the far face is at x = 0.3 - 0.05.
    CHECK(glm::distance(there.point, Vec3(0.25F, 0.5F, 0)) < 0.002F);
    CHECK(there.thickness_m == Approx(0.25).margin(0.002));
    CHECK(there.normal.x > 0.9F);
    const WallExit back = exit_of(rays, there.point + 0.1F * there.normal, -there.normal);
    // The normals differ by 0.1 rad: 0.025 m.
    CHECK(glm::distance(back.point, Vec3(0, 0.5F, 0)) < 0.03F);
    CHECK(back.wall.transmission == there.wall.transmission);
    CHECK(back.wall.scattering == there.wall.scattering);
    // A wall of one face.
    const WallExit single = exit_of(rays, Vec3(1, 1, 0), Vec3(1, 0, 0));
    CHECK(single.thickness_m == 0);
    CHECK(single.point.x > 2);
    CHECK(single.point.x < 2.001F);
    CHECK(double{single.wall.transmission[0]} == Approx(db(25)).epsilon(kRounding));
}

TEST_CASE("sound leaves a wall of one face before an opaque or oblique face behind it") {
    for (const bool oblique : {false, true}) {
        Walls walls;
        walls.face(0, walls.material(20));
        walls.face(0.3F, oblique ? walls.material(30) : walls.material(std::nullopt), -20,
                   oblique ? 0.5F : 0.0F);
        const WallExit single = exit_of(RayScene(walls.scene()), Vec3(-1, 0, 0), Vec3(1, 0, 0));
        CAPTURE(oblique);
        CHECK(single.thickness_m == 0);
        CHECK(single.point.x > 0);
        CHECK(single.point.x < 0.001F);
        CHECK(double{single.wall.transmission[0]} == Approx(db(20)).epsilon(kRounding));
    }
}
