#include "apps/dataset/plan/planned_scene.h"
#include "apps/dataset/plan/scene_drawing.h"
#include "aula/exception.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/names_in_input.h"

using namespace aula;

namespace {

/// Draws the first scenes. Drawing many positions of one scene takes long.
void draw_scenes(const Manifest& manifest) {
    constexpr double kMostPoses = 40;
    constexpr std::uint64_t kMostDrawn = 3;
    const double poses =
        manifest.sources.count.highest() +
        manifest.receivers.count.highest() * static_cast<double>(manifest.settings.array.size());
    if (poses > kMostPoses) return;
    SceneDrawing drawing(manifest);
    for (std::uint64_t index = 0; index < std::min(kMostDrawn, manifest.scenes()); ++index) {
        const PlannedScene scene = drawing.draw(index);
        const std::string line = scene_line(scene);
        test::expect_one_line(line);
        test::expect(scene_line(read_scene_line(line, "line")) == line, "a scene is read as drawn");
    }
}

}  // namespace

/// Scenes may be room.json in the folder.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    [[maybe_unused]] static const auto room = test::fuzz_folder().write(
        "room.json",
        R"({"aula": 1, "geometry": [{"box": [4, 3, 2.5], "material": "brick"}],
            "materials": {"brick": {"absorption": 0.1}},
            "sources": [{"position": [1, 1, 1]}], "listener": {"position": [2, 2, 1]}})");
    try {
        const Manifest manifest = read_manifest(test::input_file("manifest.json", data, size));
        if (!test::names_other_folder(manifest.json)) draw_scenes(manifest);
    } catch (const InputError& error) {
        test::expect_one_line(error.what());
    }
    return 0;
}
