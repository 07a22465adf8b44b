#include <cstdio>
#include <filesystem>
#include <string>
#include <system_error>

#include "apps/aula/commands.h"
#include "apps/output/json_text.h"
#include "apps/output/output_file.h"
#include "apps/output/printable.h"
#include "apps/room/edit/scene_writer.h"
#include "aula/exception.h"
#include "engine/mesh/mesh_import.h"
#include "engine/model/model_scene.h"

namespace aula {

int import_model(const Arguments& arguments) {
    namespace fs = std::filesystem;
    const fs::path& file = arguments.scene;
    if (!is_mesh_file(file))
        throw InputError(file.string(), "",
                         "is no model that Aula reads; expected .obj, .gltf, .glb, .ply or .stl "
                         "(assimp export MODEL MODEL.glb converts others)");
    const fs::path& out = arguments.out;
    // It may have been edited since an earlier import.
    std::error_code error;
    if (!out.empty() && fs::exists(fs::symlink_status(out, error)))
        throw InputError("--out", "", out.string() + " exists; expected a new name");
    const ModelScene model = scene_of_model(file, out.parent_path(), arguments.model);
    const std::string text = model_comment(file, model.guesses) + json_text(model.json) + "\n";
    // What glTF says of materials may be wrong.
    warn(parse_scene(text, file.string(), out.parent_path()).warnings, arguments.quiet);
    if (out.empty()) {
        std::fputs(text.c_str(), stdout);
    } else {
        OutputFile written(out);
        written.write(text);
        written.commit();
    }
    if (arguments.quiet) return 0;
    for (const std::string& guess : model.guesses)
        std::fprintf(stderr, "aula: guessed %s\n", printable_line(guess).c_str());
    return 0;
}

}  // namespace aula
