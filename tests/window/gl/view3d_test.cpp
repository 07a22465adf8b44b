#include "apps/window/gl/view3d.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <vector>

#include "apps/room/edit/scene_edits.h"
#include "apps/window/native_window.h"
#include "apps/window/view/camera.h"
#include "tests/support/test_scenes.h"
#include "tests/window/display.h"

// The picture, drawn on a display in memory.

namespace {

using namespace aula;
using namespace aula::test;

constexpr int kWidth = 400;
constexpr int kHeight = 300;

using Pixels = std::vector<std::array<unsigned char, 3>>;

/// A box with walls of brick, a floor of wood and a ceiling of plaster, seen by a person in it. A
/// panel of plaster may be drawn on the wall ahead.
class BoxPicture {
 public:
    explicit BoxPicture(bool has_panel = false)
        : scene_(small_room()), rays_(with_looks(has_panel)) {
        const std::vector<std::uint8_t> sides(rays_.triangle_count(), 3);
        view_.set_room(scene_, rays_, sides);
    }

    View3d& view() { return view_; }
    const RayScene& rays() const { return rays_; }

    Pixels draw() {
        Camera camera{.first_person = true};
        Pose pose;
        pose.position = 0.5F * (rays_.bounds().min + rays_.bounds().max);
        pose.yaw_rad = 0.3F;
        const Screen screen(camera, pose, {0, 0}, {kWidth, kHeight});
        ray_ahead_ = screen.ray({kWidth / 2, kHeight / 2});
        RoomStyle style;
        style.cut_away = false;
        style.first_person = true;
        view_.draw(screen.matrix(), screen.eye(), style, 0, 0, kWidth, kHeight);
        Pixels pixels(kWidth * kHeight);
        glPixelStorei(GL_PACK_ALIGNMENT, 1);
        glReadPixels(0, 0, kWidth, kHeight, GL_RGB, GL_UNSIGNED_BYTE, pixels.data());
        return pixels;
    }

    /// The triangles of the wall in the middle of the picture.
    std::vector<std::uint32_t> wall_ahead() const {
        Hit hit;
        rays_.intersect(std::span(&ray_ahead_, 1), std::span(&hit, 1));
        return surface_of(rays_, hit.triangle);
    }

 private:
    const Scene& with_looks(bool has_panel) {
        scene_.materials.assign(3, scene_.materials.at(0));
        scene_.materials[0].name = "brick";
        scene_.materials[1].name = "wood_floor";
        scene_.materials[2].name = "plaster";
        for (Object& object : scene_.objects) {
            const RayScene rays(scene_);
            for (std::uint32_t t = 0; t < rays.triangle_count(); ++t) {
                const RayScene::Triangle& triangle = rays.triangle(t);
                const bool flat = std::abs(triangle.normal.z) > 0.5F;
                const bool low = triangle.vertices[0].z < 0.5F * rays.bounds().max.z;
                object.triangle_materials[t] = !flat ? 0 : low ? 1 : 2;
            }
        }
        if (has_panel) {
            const Bounds room = geometry_bounds(scene_.objects);
            const Vec3 low = room.min + 0.1F * (room.max - room.min);
            const Vec3 high = room.max - 0.1F * (room.max - room.min);
            const float x = room.max.x;
            scene_.add_object(
                {{x, low.y, low.z}, {x, high.y, low.z}, {x, high.y, high.z}, {x, low.y, high.z}},
                {{0, 1, 2}, {0, 2, 3}}, "plaster");
        }
        return scene_;
    }

    Scene scene_;
    RayScene rays_;
    View3d view_;
    Ray ray_ahead_;
};

/// The mean colour of a rectangle.
Colour mean(const Pixels& pixels, int x, int y, int width, int height) {
    Colour sum(0);
    for (int row = y; row < y + height; ++row)
        for (int column = x; column < x + width; ++column) {
            const auto& p = pixels[static_cast<std::size_t>(row * kWidth + column)];
            sum += Colour(p[0], p[1], p[2]);
        }
    return sum / static_cast<float>(255 * width * height);
}

/// The standard deviation of the brightness in a rectangle.
double contrast(const Pixels& pixels, int x, int y, int width, int height) {
    double sum = 0;
    double squares = 0;
    for (int row = y; row < y + height; ++row)
        for (int column = x; column < x + width; ++column) {
            const auto& p = pixels[static_cast<std::size_t>(row * kWidth + column)];
            const double value = (p[0] + p[1] + p[2]) / 765.0;
            sum += value;
            squares += value * value;
        }
    const double count = width * height;
    return std::sqrt(std::max(0.0, squares / count - sum * sum / (count * count)));
}

}  // namespace

TEST_CASE("In first person walls, floor and ceiling differ, and a selected wall keeps its colour") {
    if (!are_installed("Xvfb")) {
        WARN("skipped: Xvfb is not installed");
        return;
    }
    const Display display("800x600");
    if (!display.running() || !opens_window()) {
        WARN("skipped: no display with OpenGL 3.3 can run here");
        return;
    }
    const Glfw glfw;
    const NativeWindow window(640, 480);
    BoxPicture box;
    const Pixels plain = box.draw();

    // OpenGL's rows run upwards.
    const Colour floor = mean(plain, 110, 4, 90, 10);
    const Colour wall = mean(plain, 150, 130, 100, 40);
    const Colour ceiling = mean(plain, 110, 285, 90, 10);
    constexpr float kTold = 0.1F;  // of the largest distance in a channel
    CHECK(glm::distance(floor, wall) > kTold);
    CHECK(glm::distance(wall, ceiling) > kTold);
    CHECK(glm::distance(floor, ceiling) > kTold);
    // Bricks have joints.
    CHECK(contrast(plain, 150, 130, 100, 40) > 3 * contrast(plain, 110, 285, 90, 10));

    // A panel that is drawn on the wall is in front of it everywhere.
    const Pixels panel = BoxPicture(true).draw();
    CHECK(contrast(panel, 150, 130, 100, 40) < contrast(plain, 150, 130, 100, 40) / 3);

    box.view().set_picked(box.rays(), box.wall_ahead());
    const Pixels picked = box.draw();
    std::size_t same = 0;
    for (int row = 130; row < 170; ++row)
        for (int column = 150; column < 250; ++column) {
            const auto at = static_cast<std::size_t>(row * kWidth + column);
            same += plain[at] == picked[at] ? 1 : 0;
        }
    CHECK(same > 4000 * 7 / 10);
    CHECK(same < 4000 * 9 / 10);
}
