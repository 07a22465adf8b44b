#include "apps/aula/scene_lookup.h"

#include <string>
#include <system_error>

#include "aula/exception.h"
#include "process/files.h"

namespace aula {

namespace fs = std::filesystem;

std::vector<fs::path> scene_folders() {
    std::error_code error;
    const fs::path program = program_file(error).parent_path();
    std::vector<fs::path> folders;
    if (error) return folders;
    for (const char* const relative : {AULA_INSTALLED_SCENES, AULA_SOURCE_SCENES}) {
        fs::path folder = (program / relative).lexically_normal();
        if (fs::is_directory(folder, error)) folders.push_back(std::move(folder));
    }
    return folders;
}

fs::path find_scene(const fs::path& name, const std::vector<fs::path>& folders) {
    std::error_code error;
    if (name.has_parent_path() || fs::exists(name, error)) return name;
    std::string searched;
    for (const fs::path& folder : folders) {
        for (const fs::path& file : {folder / name, folder / utf8_path(name.string() + ".json")})
            if (fs::is_regular_file(file, error)) return file;
        searched += " or " + folder.string();
    }
    throw InputError(name.string(), "",
                     "there is no such file; expected a scene file, or the name of a scene in "
                     "the working directory" +
                         searched);
}

}  // namespace aula
