#include "apps/dataset/plan/plan.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "apps/dataset/base/json_values.h"
#include "apps/dataset/base/sha256.h"
#include "apps/dataset/plan/scene_drawing.h"
#include "apps/output/folder_lock.h"
#include "apps/output/formatted.h"
#include "apps/output/json_text.h"
#include "apps/output/output_file.h"
#include "aula/exception.h"
#include "process/files.h"
#include "process/regular_file.h"

namespace aula {

namespace {

namespace fs = std::filesystem;

constexpr const char* kNewLines = ".plan-new.jsonl";  ///< before their hash is known

/// Creates a folder; removes it again unless keep() is called.
class NewFolder {
 public:
    explicit NewFolder(fs::path folder) : folder_(std::move(folder)) {
        std::error_code error;
        created_ = fs::create_directories(folder_, error);
        if (!fs::is_directory(folder_))
            throw InputError(folder_.string(), "",
                             "cannot be created" +
                                 (error ? ", " + error.message() : std::string()) +
                                 "; expected the name of a folder");
    }
    ~NewFolder() {
        std::error_code ignored;
        if (created_) fs::remove(folder_, ignored);
    }
    NewFolder(const NewFolder&) = delete;
    NewFolder& operator=(const NewFolder&) = delete;
    void keep() { created_ = false; }

 private:
    fs::path folder_;
    bool created_ = false;
};

/// Where the lines of a plan with this hash are until they replace those of an earlier plan.
fs::path lines_beside(const fs::path& folder, const std::string& sha256) {
    return folder / (".plan-" + sha256 + ".jsonl");
}

bool is_lines_beside(const std::string& name) {
    return name.starts_with(".plan-") && name.ends_with(".jsonl");
}

bool has_shards(const fs::path& folder) {
    const fs::directory_iterator files(folder);
    return std::any_of(begin(files), end(files), [](const fs::directory_entry& entry) {
        return entry.path().filename().string().starts_with("shard-");
    });
}

/// The first line of plan.jsonl: the settings of the manifest.
std::string settings_line(const Manifest& manifest) {
    JsonValue::Object line{{"aula_plan", json_value(std::uint64_t{1})},
                           {"version", json_value(std::string(AULA_VERSION))},
                           {"scenes", json_value(manifest.scenes())}};
    const auto& root = std::get<JsonValue::Object>(manifest.json.value);
    for (const std::string& key : settings_keys())
        if (const JsonValue* const value = find_member(root, key)) line.push_back({key, *value});
    return json_line(json_value(std::move(line)));
}

/// plan.json.
std::string plan_text(const Plan& plan, const Manifest& manifest) {
    JsonValue::Array rows;
    for (const ShardRange& shard : plan.shards)
        rows.push_back(
            json_value(JsonValue::Array{json_value(shard.first_scene), json_value(shard.first_item),
                                        json_value(shard.offset), json_value(shard.sha256)}));
    const fs::path folder = fs::absolute(manifest.file).parent_path().lexically_normal();
    return json_text(json_value(JsonValue::Object{{"aula_plan", json_value(std::uint64_t{1})},
                                                  {"plan_sha256", json_value(plan.sha256)},
                                                  {"manifest_folder", json_value(folder.string())},
                                                  {"scenes", json_value(plan.scenes)},
                                                  {"items", json_value(plan.items)},
                                                  {"empty_scenes", json_value(plan.empty_scenes)},
                                                  {"shards", json_value(std::move(rows))}})) +
           "\n";
}

/// Replaces the plan of a folder. plan.json decides in one step which plan the folder has: the
/// lines of the new one are at first in lines_beside(), where lines_file() finds them.
void replace_plan(const fs::path& folder, OutputFile& lines, const std::string& sha256,
                  const std::string& text) {
    const fs::path plan = folder / Plan::kFile;
    const fs::path beside = lines_beside(folder, sha256);
    if (!fs::exists(plan) || read_regular_file(plan, Plan::kMostBytes, Plan::kExpected) != text) {
        if (has_shards(folder))
            throw InputError(folder.string(), "",
                             "has shards of another plan; expected another folder, or none of its "
                             "files shard-*.tar");
        check_replaceable(folder / Plan::kLines);
        OutputFile out(plan);
        out.write(text);
        lines.commit();
        rename_flushed(folder / kNewLines, beside);
        out.commit();
    }
    if (fs::exists(beside)) rename_flushed(beside, folder / Plan::kLines);
    // What ended processes have left.
    std::vector<fs::path> left;
    for (const auto& entry : fs::directory_iterator(folder))
        if (is_lines_beside(entry.path().filename().string())) left.push_back(entry.path());
    for (const fs::path& file : left) fs::remove(file);
}

}  // namespace

fs::path Plan::lines_file() const {
    const fs::path beside = lines_beside(folder, sha256);
    std::error_code error;
    return fs::exists(beside, error) ? beside : folder / kLines;
}

fs::path Plan::shard_file(std::size_t shard) const {
    return folder / formatted("shard-%05zu.tar", shard);
}

std::string Plan::item_name(std::uint64_t item) {
    return formatted("%06llu", static_cast<unsigned long long>(item));
}

bool write_plan(const Manifest& manifest, const fs::path& folder, std::size_t shards,
                const std::function<bool()>& continues) {
    const std::uint64_t scenes = manifest.scenes();
    if (shards > scenes)
        throw InputError("--shards: " + std::to_string(shards) + " shards of " +
                         std::to_string(scenes) + " scenes; expected at most one for each scene");
    NewFolder created(folder);
    const FolderLock lock(folder);
    OutputFile out(folder / kNewLines);
    Plan plan;
    plan.scenes = scenes;
    Sha256 hash;
    const std::string settings = settings_line(manifest) + "\n";
    out.write(settings);
    hash.add(settings);
    Sha256 shard_hash = hash;
    const Sha256 hash_of_settings = hash;
    std::uint64_t offset = settings.size();
    SceneDrawing drawing(manifest);
    for (std::uint64_t index = 0; index < scenes; ++index) {
        if (!continues()) return false;
        if (plan.shards.size() * scenes / shards == index) {
            if (index > 0) plan.shards.back().sha256 = shard_hash.hex();
            ShardRange& shard = plan.shards.emplace_back();
            shard.first_scene = index;
            shard.first_item = plan.items;
            shard.offset = offset;
            shard_hash = hash_of_settings;
        }
        PlannedScene scene = drawing.draw(index);
        scene.first_item = plan.items;
        plan.items += scene.items;
        if (!scene.error.empty()) ++plan.empty_scenes;
        const std::string line = scene_line(scene) + "\n";
        out.write(line);
        hash.add(line);
        shard_hash.add(line);
        offset += line.size();
    }
    plan.shards.back().sha256 = shard_hash.hex();
    plan.sha256 = hash.hex();
    replace_plan(folder, out, plan.sha256, plan_text(plan, manifest));
    created.keep();
    return true;
}

}  // namespace aula
