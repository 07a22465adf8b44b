#include <cstdint>
#include <utility>

#include "aula/engine/scene_file.h"
#include "engine/mesh/mesh_import.h"
#include "engine/model/model_scene.h"
#include "engine/scene/scene_reading.h"
#include "process/regular_file.h"

namespace aula {

LoadedScene load_scene(const std::filesystem::path& file, SignalFiles signals) {
    constexpr std::uint64_t kMaxBytes = std::uint64_t{256} << 20U;  // bounds memory
    const std::filesystem::path folder = file.parent_path();
    const std::string name = file.string();
    if (!is_mesh_file(file))
        return parse_scene(read_regular_file(file, kMaxBytes, "a scene file"), name, folder,
                           signals);
    return load_model(file, {}, signals);
}

LoadedScene load_model(const std::filesystem::path& file, const ModelOptions& options,
                       SignalFiles signals) {
    const std::string name = file.string();
    const std::filesystem::path folder = file.parent_path();
    ModelScene model = scene_of_model(file, folder, options);
    LoadedScene loaded = read_scene(std::move(model.json), name, folder, signals);
    for (const std::string& guess : model.guesses)
        loaded.warnings.push_back(name + ": guessed " + guess);
    loaded.guesses = std::move(model.guesses);
    return loaded;
}

}  // namespace aula
