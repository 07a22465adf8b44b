#include "apps/window/model/edited_scene.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "apps/room/edit/scene_edits.h"

namespace aula {

namespace {

std::filesystem::file_time_type time_of(const std::filesystem::path& file) {
    std::error_code none;
    return std::filesystem::last_write_time(file, none);
}

/// The bounds of the geometry; without geometry, 1 m around the listener and the sources.
Bounds shown_bounds(const Scene& scene, const RayScene& rays) {
    Bounds bounds = rays.bounds();
    if (rays.triangle_count() > 0) return bounds;
    bounds.add(scene.listener.pose_at(0).position);
    for (const Source& source : scene.sources) bounds.add(source.position_at(0));
    bounds.min -= 1.0F;
    bounds.max += 1.0F;
    return bounds;
}

bool same_sources(const Scene& a, const Scene& b) {
    return std::equal(a.sources.begin(), a.sources.end(), b.sources.begin(), b.sources.end(),
                      [](const Source& s, const Source& t) { return s.name == t.name; });
}

}  // namespace

OpenedScene open_scene(const WindowOptions& options, const std::filesystem::path& file) {
    const auto time = time_of(file);
    auto read = std::make_shared<const LoadedScene>(options.load(file));
    Scene scene = read->scene;
    if (options.change) options.change(scene);
    for (Source& source : scene.sources) source.loop = true;
    auto rays = std::make_unique<RayScene>(scene);
    return {std::make_shared<const Scene>(std::move(scene)), std::move(read), std::move(rays), file,
            time};
}

EditedScene::EditedScene(OpenedScene opened) : history_(Document{}) { restart(std::move(opened)); }

void EditedScene::restart(OpenedScene opened) {
    file_ = std::move(opened.file);
    file_time_ = opened.file_time;
    history_.restart({std::move(opened.scene), std::move(opened.read), {}});
    take_geometry(std::move(opened.rays));
    ++version_;
}

void EditedScene::take_geometry(std::unique_ptr<RayScene> rays) {
    rays_ = std::move(rays);
    bounds_ = shown_bounds(scene(), *rays_);
    surface_.reset();
    ++geometry_version_;
}

void EditedScene::move_objects(double time_s) {
    const auto moves = [](const Object& object) { return object.path.has_value(); };
    if (std::any_of(scene().objects.begin(), scene().objects.end(), moves)) rays_->move(time_s);
}

EditedScene::Change EditedScene::change(Document document) {
    const auto before = shared_scene();
    history_.change(std::move(document));
    return update(*before, nullptr);
}

/// Updates all that depends on the scene. Builds `rays` if null and the geometry has changed.
EditedScene::Change EditedScene::update(const Scene& before, std::unique_ptr<RayScene> rays) {
    if (&scene() == &before) return {};
    ++version_;
    if (!same_geometry(scene(), before))
        take_geometry(rays ? std::move(rays) : std::make_unique<RayScene>(scene()));
    return {.scene = true, .sources = !same_sources(scene(), before)};
}

EditedScene::Change EditedScene::edit(Scene edited, SourcePositions positions) {
    return change({std::make_shared<const Scene>(std::move(edited)), history_.now().read,
                   std::move(positions)});
}

EditedScene::Change EditedScene::edit_remotely(Scene edited, SourcePositions positions) {
    if (edited_remotely_ == shared_scene()) history_.undo();
    const Change made = edit(std::move(edited), std::move(positions));
    edited_remotely_ = shared_scene();
    return made;
}

void EditedScene::move_sources(SourcePositions positions) {
    change({shared_scene(), history_.now().read, std::move(positions)});
}

EditedScene::Change EditedScene::reload(OpenedScene opened) {
    const auto before = shared_scene();
    history_.change({std::move(opened.scene), std::move(opened.read), {}});
    return update(*before, std::move(opened.rays));
}

EditedScene::Change EditedScene::undo() {
    const auto before = shared_scene();
    history_.undo();
    return update(*before, nullptr);
}

EditedScene::Change EditedScene::redo() {
    const auto before = shared_scene();
    history_.redo();
    return update(*before, nullptr);
}

void EditedScene::pick(std::uint32_t triangle) {
    Surface surface{surface_of(*rays_, triangle), triangle, 0};
    for (const std::uint32_t t : surface.triangles) surface.area_m2 += rays_->triangle(t).area_m2();
    surface_ = std::move(surface);
}

bool EditedScene::file_changed(double now_s) {
    constexpr double kInterval_s = 0.5;
    if (now_s < file_checked_s_ + kInterval_s) return false;
    file_checked_s_ = now_s;
    const auto time = time_of(file_);
    return std::exchange(file_time_, time) != time;
}

}  // namespace aula
