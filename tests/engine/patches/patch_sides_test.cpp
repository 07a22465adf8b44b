// Patches that panels divide.

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <optional>
#include <set>
#include <vector>

#include "engine/base/tolerances.h"
#include "tests/engine/patches/surveyed.h"
#include "tests/support/rooms.h"

using namespace aula;
using aula::test::Surveyed;

namespace {

const Vec3 kInside(1, 1, 2);
const Vec3 kUp(0, 0, 1);

/// A vertical sheet over a line.
Object sheet(const Vec3& begin, const Vec3& end, float height_m) {
    Object object;
    object.vertices = {begin, end, end + height_m * kUp, begin + height_m * kUp};
    object.triangles = {{0, 1, 2}, {0, 2, 3}};
    object.triangle_materials = {0, 0};
    return object;
}

/// A square sheet across x that is at one of these positions in each second.
Object moving_sheet(float side_m, const std::vector<Vec3>& positions) {
    Object object = sheet(Vec3(0), Vec3(0, side_m, 0), side_m);
    object.path.emplace();
    for (std::size_t k = 0; k < positions.size(); ++k)
        object.path->points.push_back({static_cast<double>(k), {positions[k]}});
    return object;
}

Scene room_with(const std::vector<Object>& sheets) {
    Scene scene = test::room(test::box(Vec3(10, 4, 3)), kInside);
    scene.objects.insert(scene.objects.end(), sheets.begin(), sheets.end());
    return scene;
}

Vec3 on_floor(float x_m, float y_m) { return {x_m, y_m, tolerances::kOffset_m}; }

/// The row for the energy that leaves the floor at a point.
struct FloorRow {
    std::uint32_t patch = PatchGrid::kNone;
    std::uint32_t row = PatchGrid::kNone;
    float factor = 0;
    PatchGrid::Radiator radiator;
};

FloorRow row_at(const Surveyed& s, const Vec3& point) {
    FloorRow at;
    at.patch = s.grid.find(point, kUp);
    LanePoints points;
    LanePoints normals;
    points.set(0, point);
    normals.set(0, kUp);
    std::array<std::uint32_t, kLanes> rows{};
    std::array<float, kLanes> factors{};
    s.grid.find_rows(points, normals, 1, rows, factors);
    at.row = rows[0];
    at.factor = factors[0];
    const Ray ray{point + 0.5F * kUp, -kUp};
    Hit hit;
    s.rays.intersect({&ray, 1}, {&hit, 1});
    at.radiator = s.grid.find_radiator(hit.triangle, point, kUp);
    return at;
}

/// Checks that energy at the point is radiated by an area on its side.
void check_side(const Surveyed& s, const FloorRow& at, double area_m2) {
    CHECK(at.row != PatchGrid::kNone);
    CHECK(at.row != at.patch);
    CHECK(at.radiator.row == at.row);
    // 256 quasi-random samples of a patch: some 2 % of its 0.25 m2.
    CHECK(1 / double{at.factor * at.radiator.per_m2} == Approx(area_m2).margin(0.005));
    // The patch radiates the energy, up to rounding.
    CHECK(double{at.factor * s.grid.per_m2(at.row) * s.grid.area_m2(at.patch)} ==
          Approx(1).epsilon(1e-5));
}

void check_undivided(const Surveyed& s, const FloorRow& at) {
    CHECK(at.row == at.patch);
    CHECK(at.factor == 1);
    CHECK(at.radiator.row == at.patch);
    CHECK(double{at.radiator.per_m2} == Approx(1 / 0.25).epsilon(1e-4));
    CHECK(s.grid.per_m2(at.patch) == at.radiator.per_m2);
}

}  // namespace

TEST_CASE(
    "a panel divides the patches that it crosses, unless it is smaller than a quarter of one") {
    // A sheet in the plane x = 4.2 m: of the patch of the floor from 4 to 4.5 m it leaves 0.1 and
    // 0.15 m2.
    const Vec3 place(4.2F, 1.1F, 0.05F);
    for (const float side_m : {1.0F, 0.3F}) {
        CAPTURE(side_m);
        const Surveyed s(room_with({moving_sheet(side_m, {place, Vec3(8, 3, 0.05F)})}), 0.5F,
                         kInside);
        const FloorRow left = row_at(s, on_floor(4.1F, 1.25F));
        const FloorRow right = row_at(s, on_floor(4.4F, 1.25F));
        CHECK(left.patch == right.patch);
        CHECK(left.row != right.row);
        check_side(s, left, 0.1);
        check_side(s, right, 0.15);
    }
    const Surveyed s(room_with({moving_sheet(0.2F, {place, Vec3(8, 3, 0.05F)})}), 0.5F, kInside);
    check_undivided(s, row_at(s, on_floor(4.1F, 1.25F)));
    check_undivided(s, row_at(s, on_floor(4.4F, 1.25F)));
}

TEST_CASE("a moving panel divides the patches where it is, and no others") {
    std::vector<Vec3> positions;
    for (int k = 0; k <= 12; ++k)
        positions.emplace_back(3.2F + 0.25F * static_cast<float>(k), 1.1F, 0.05F);
    positions.emplace_back(30.0F, 1.1F, 0.05F);
    Surveyed s(room_with({moving_sheet(1, positions)}), 0.5F, kInside);
    std::size_t size = 0;
    std::set<std::uint32_t> patches;
    std::set<std::uint32_t> rows;
    for (int k = 1; k <= 12; ++k) {
        s.rays.move(k);
        s.grid.scene_moved();
        const float x_m = positions[static_cast<std::size_t>(k)].x;
        CAPTURE(x_m);
        const FloorRow left = row_at(s, on_floor(x_m - 0.03F, 1.25F));
        const FloorRow right = row_at(s, on_floor(x_m + 0.03F, 1.25F));
        CHECK(left.patch == right.patch);
        CHECK(left.row != right.row);
        const double left_m = std::fmod(double{x_m}, 0.5);
        check_side(s, left, 0.5 * left_m);
        check_side(s, right, 0.5 * (0.5 - left_m));
        patches.insert(left.patch);
        rows.insert({left.row, right.row});
        // The cells beside it.
        check_undivided(s, row_at(s, on_floor(x_m - 0.5F, 1.25F)));
        check_undivided(s, row_at(s, on_floor(x_m + 0.5F, 1.25F)));
        // Exact: it crosses three patches of the floor, of which each has two rows.
        CHECK(s.grid.reached_rows() == s.grid.reached() + 3);
        if (k <= 2) size = s.grid.size();
        CHECK(s.grid.size() == size);
    }
    // Companion: there are fewer numbers than sides.
    CHECK(patches.size() >= 6);
    CHECK(rows.size() < 2 * patches.size());
    s.rays.move(13);
    s.grid.scene_moved();
    CHECK(s.grid.reached_rows() == s.grid.reached());
    for (const float x_m : {6.15F, 6.25F}) check_undivided(s, row_at(s, on_floor(x_m, 1.25F)));
}

TEST_CASE("a static partition keeps its rows unless a moving panel crosses the same cells") {
    // An oblique partition, which crosses the cell of 6.5 to 7 m by 2 to 2.5 m between the first
    // two points. A sheet moves elsewhere, and then between the last two.
    const Object partition = sheet(Vec3(6, 1, 0), Vec3(7, 3, 0), 2);
    const Vec3 left_point = on_floor(6.55F, 2.4F);
    const Vec3 right_point = on_floor(6.9F, 2.1F);
    const Vec3 between_point = on_floor(6.7F, 2.1F);
    std::vector<Vec3> positions;
    for (int k = 0; k < 10; ++k)
        positions.emplace_back(3.2F + 0.25F * static_cast<float>(k), 1.1F, 0.05F);
    positions.emplace_back(6.8F, 1.6F, 0.05F);
    Surveyed s(room_with({partition, moving_sheet(1, positions)}), 0.5F, kInside);
    const FloorRow left = row_at(s, left_point);
    const FloorRow right = row_at(s, right_point);
    CHECK(left.row != right.row);
    check_side(s, left, 0.0625);
    check_side(s, right, 0.1875);
    CHECK(row_at(s, between_point).row == right.row);
    const std::size_t reached_rows = s.grid.reached_rows();
    const auto check_same = [&](const FloorRow& now, const FloorRow& before) {
        CHECK(now.factor == before.factor);
        CHECK(now.radiator.row == now.row);
        CHECK(now.radiator.per_m2 == before.radiator.per_m2);
    };
    for (int k = 1; k < 10; ++k) {
        s.rays.move(k);
        s.grid.scene_moved();
        CHECK(row_at(s, left_point).row == left.row);
        CHECK(row_at(s, right_point).row == right.row);
        check_same(row_at(s, left_point), left);
        check_same(row_at(s, right_point), right);
        CHECK(s.grid.reached_rows() == reached_rows);
    }
    std::optional<std::size_t> size;
    for (int round = 0; round < 4; ++round) {
        CAPTURE(round);
        s.rays.move(10);
        s.grid.scene_moved();
        check_side(s, row_at(s, left_point), 0.0625);
        check_side(s, row_at(s, right_point), 0.1);
        check_side(s, row_at(s, between_point), 0.0875);
        const std::set<std::uint32_t> three{row_at(s, left_point).row, row_at(s, right_point).row,
                                            row_at(s, between_point).row};
        CHECK(three.size() == 3);
        if (!size) size = s.grid.size();
        s.rays.move(0);
        s.grid.scene_moved();
        // The sides are the same again, in rows with any numbers.
        CHECK(row_at(s, left_point).row != row_at(s, right_point).row);
        CHECK(row_at(s, between_point).row == row_at(s, right_point).row);
        check_same(row_at(s, left_point), left);
        check_same(row_at(s, right_point), right);
        CHECK(s.grid.reached_rows() == reached_rows);
        CHECK(s.grid.size() == *size);
    }
}

TEST_CASE("six partitions keep the rows of their cell while a smaller moving panel crosses it") {
    // A fan of oblique partitions around the middle of a cell.
    const Vec3 middle(6.75F, 2.25F, 0);
    std::vector<Object> objects;
    for (int k = 0; k < 6; ++k) {
        const float angle = 0.2F + 0.5F * static_cast<float>(k);
        const Vec3 along(std::cos(angle), std::sin(angle), 0);
        objects.push_back(sheet(middle - along, middle + along, 2));
    }
    objects.push_back(moving_sheet(0.3F, {Vec3(3.2F, 1.1F, 0.05F), Vec3(6.6F, 2.1F, 0.05F)}));
    Surveyed s(room_with(objects), 0.5F, kInside);
    const auto rows = [&] {
        std::vector<std::uint32_t> all;
        for (int k = 0; k < 6; ++k) {
            const float angle = 0.45F + 0.5F * static_cast<float>(k);
            for (const float side : {-0.15F, 0.15F})
                all.push_back(row_at(s, on_floor(middle.x + side * std::cos(angle),
                                                 middle.y + side * std::sin(angle)))
                                  .row);
        }
        return all;
    };
    const std::vector<std::uint32_t> before = rows();
    CHECK(std::set(before.begin(), before.end()).size() == before.size());
    for (const int position : {1, 0, 1}) {
        CAPTURE(position);
        s.rays.move(position);
        s.grid.scene_moved();
        CHECK(rows() == before);
    }
}
