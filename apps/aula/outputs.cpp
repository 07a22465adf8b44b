#include "apps/aula/outputs.h"

#include <string>
#include <system_error>
#include <vector>

#include "apps/documents/parameter_map.h"
#include "apps/documents/parameter_text.h"
#include "audio/file/part_file.h"
#include "aula/exception.h"
#include "engine/mesh/mesh_import.h"
#include "process/files.h"

namespace aula {

namespace {

namespace fs = std::filesystem;

/// The file behind an output's name, which need not exist yet.
fs::path target_of(const fs::path& output) {
    try {
        return file_behind_links(output);
    } catch (const std::system_error& error) {
        throw InputError(output.string() + ": cannot be written, " + error.code().message() +
                         "; expected a name in a folder that can be written to");
    }
}

/// Whether an output, which need not exist yet, names the same file as another output or an input.
bool same_file(const fs::path& output, const fs::path& other) {
    std::error_code error;
    // Compares device and inode.
    if (fs::equivalent(output, other, error)) return true;
    if (fs::exists(output, error) || fs::exists(other, error)) return false;
    const fs::path target = target_of(output);
    try {
        return target == file_behind_links(other);
    } catch (const std::system_error&) {
        return false;  // an input in a folder that cannot be read: who reads it says so
    }
}

/// Whether the output replaces the file. Devices and pipes are written directly, and may be the
/// target of several outputs.
bool is_replaced(const fs::path& file) {
    std::error_code error;
    return !fs::exists(file, error) || fs::is_regular_file(file, error);
}

std::vector<fs::path> outputs_of(const Arguments& arguments, const Scene& scene) {
    std::vector<fs::path> files;
    if (!arguments.offline.empty()) files.push_back(arguments.offline);
    if (!arguments.html.empty()) files.push_back(arguments.html);
    if (arguments.ir)
        for (std::size_t s = 0; s < scene.sources.size(); ++s)
            files.push_back(response_file(*arguments.ir, scene, s));
    // Sources must have different files; the files of one parameter show it for all.
    if (!arguments.out.empty())
        for (std::size_t s = 0; s < scene.sources.size(); ++s)
            files.push_back(map_files(arguments, scene, s, kMappedParameters[0]).table);
    for (const auto& file :
         {arguments.echogram, arguments.report_json, arguments.json, arguments.screenshot})
        if (file) files.push_back(*file);
    return files;
}

std::vector<fs::path> inputs_of(const Arguments& arguments, const Scene& scene) {
    std::vector<fs::path> files{arguments.scene};
    for (const Object& object : scene.objects)
        files.insert(files.end(), object.files.begin(), object.files.end());
    for (const Source& source : scene.sources) {
        if (source.signal == Source::Signal::file) {
            const auto inside = SoundInModel::of_name(source.signal_file);
            files.push_back(inside ? inside->model : source.signal_file);
        }
        if (!source.directivity_file.empty()) files.push_back(source.directivity_file);
    }
    files.insert(files.end(), arguments.measured.begin(), arguments.measured.end());
    for (const fs::path& file : {arguments.playback.hrtf, arguments.playback.headphones})
        if (!file.empty()) files.push_back(file);
    return files;
}

void check_not_replaced(const fs::path& output, const std::vector<fs::path>& inputs) {
    for (const fs::path& input : inputs)
        if (same_file(output, input))
            throw InputError(output.string() + ": would replace the input " + input.string() +
                             "; expected the name of another file");
}

/// Checks before the measurement what would otherwise fail after it.
void check_map(const Arguments& arguments, const Scene& scene,
               const std::vector<fs::path>& inputs) {
    for (std::size_t s = 0; s < scene.sources.size(); ++s) {
        for (const std::size_t parameter : mapped_parameters(arguments.map_interaural)) {
            const auto [table, picture] = map_files(arguments, scene, s, parameter);
            for (const fs::path& file : {table, picture}) {
                std::error_code error;
                if (fs::is_directory(file, error))
                    throw InputError(file.string() +
                                     ": is a folder; expected another folder for the map");
                check_replaceable(file);
                check_not_replaced(file, inputs);
            }
        }
    }
}

}  // namespace

MapFiles map_files(const Arguments& arguments, const Scene& scene, std::size_t source,
                   std::size_t parameter) {
    const std::string symbol = parameter_text(parameter).symbol;
    return {response_file(arguments.out / (symbol + ".csv"), scene, source),
            response_file(arguments.out / (symbol + ".png"), scene, source)};
}

fs::path response_file(const fs::path& file, const Scene& scene, std::size_t source) {
    if (scene.sources.size() == 1) return file;
    std::string name = scene.sources[source].name;
    for (char& c : name) {
        const bool letter = (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
        const bool other = (c >= '0' && c <= '9') || c == '.' || c == '_' || c == '-';
        if (!letter && !other) c = '_';
    }
    fs::path out = file;
    out.replace_filename(file.stem().string() + "-" + name + file.extension().string());
    return out;
}

void check_outputs(const Arguments& arguments, const Scene& scene) {
    const std::vector<fs::path> outputs = outputs_of(arguments, scene);
    const std::vector<fs::path> inputs = inputs_of(arguments, scene);
    if (!arguments.out.empty()) check_map(arguments, scene, inputs);
    for (std::size_t i = 0; i < outputs.size(); ++i) {
        if (!is_replaced(outputs[i])) continue;
        target_of(outputs[i]);  // refuses names that cannot be written
        check_replaceable(outputs[i]);
        check_not_replaced(outputs[i], inputs);
        for (std::size_t k = 0; k < i; ++k)
            if (same_file(outputs[i], outputs[k]))
                throw InputError(outputs[i].string() +
                                 ": is the file of two outputs; expected a file for each "
                                 "(sources need names that differ in [A-Za-z0-9._-])");
    }
}

}  // namespace aula
