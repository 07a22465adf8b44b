#include "apps/dataset/plan/plan.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "apps/dataset/base/json_values.h"
#include "apps/dataset/base/sha256.h"
#include "apps/dataset/plan/scene_drawing.h"
#include "apps/session/base/formatted.h"
#include "apps/session/base/json_text.h"
#include "apps/session/base/output_file.h"
#include "aula/exception.h"
#include "engine/input/json_reader.h"
#include "engine/input/regular_file.h"

namespace aula {

namespace {

namespace fs = std::filesystem;

constexpr const char* kPlan = "plan.json";
constexpr const char* kLines = "plan.jsonl";
constexpr const char* kExpected = "expected the plan of aula dataset plan";
constexpr std::uint64_t kMaxBytes = std::uint64_t{1} << 30U;

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

std::string read_file(const fs::path& file) {
    try {
        return read_regular_file(file, kMaxBytes);
    } catch (const InputError& error) {
        const std::string reason = error.what();
        throw InputError(file.string(), "", reason.substr(0, reason.find(';')) + "; " + kExpected);
    }
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
std::string plan_text(const std::string& hash, const Manifest& manifest,
                      const std::vector<ShardRange>& shards, std::uint64_t items) {
    JsonValue::Array rows;
    for (const ShardRange& shard : shards)
        rows.push_back(
            json_value(JsonValue::Array{json_value(shard.first_scene), json_value(shard.first_item),
                                        json_value(shard.offset)}));
    const fs::path folder = fs::absolute(manifest.file).parent_path().lexically_normal();
    return json_text(json_value(JsonValue::Object{{"aula_plan", json_value(std::uint64_t{1})},
                                                  {"plan_sha256", json_value(hash)},
                                                  {"manifest_folder", json_value(folder.string())},
                                                  {"scenes", json_value(manifest.scenes())},
                                                  {"items", json_value(items)},
                                                  {"shards", json_value(std::move(rows))}})) +
           "\n";
}

/// Replaces the plan of a folder. plan.json is absent while the two do not match.
void replace_plan(const fs::path& folder, OutputFile& lines, const std::string& text) {
    const fs::path plan = folder / kPlan;
    const bool exists = fs::exists(plan);
    if (exists && read_file(plan) == text) return;
    if (has_shards(folder))
        throw InputError(folder.string(), "",
                         "has shards of another plan; expected another folder, or none of its "
                         "files shard-*.tar");
    fs::remove(plan);
    OutputFile out(plan);
    out.write(text);
    lines.commit();
    out.commit();
}

}  // namespace

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
    OutputFile out(folder / kLines);
    Sha256 hash;
    std::uint64_t offset = 0;
    const auto write = [&](const std::string& line) {
        out.write(line + "\n");
        hash.add(line + "\n");
        offset += line.size() + 1;
    };
    write(settings_line(manifest));
    std::vector<ShardRange> ranges;
    SceneDrawing drawing(manifest);
    std::uint64_t item = 0;
    for (std::uint64_t index = 0; index < scenes; ++index) {
        if (!continues()) return false;
        if (ranges.size() * scenes / shards == index)
            ranges.push_back({.first_scene = index, .first_item = item, .offset = offset});
        PlannedScene scene = drawing.draw(index);
        scene.first_item = item;
        item += scene.items;
        write(scene_line(scene));
    }
    replace_plan(folder, out, plan_text(hash.hex(), manifest, ranges, item));
    created.keep();
    return true;
}

Plan read_plan(const fs::path& folder) {
    const std::string name = (folder / kPlan).string();
    const JsonValue value = parse_json(read_file(name), name);
    const JsonReader json(value, name);
    Plan plan;
    plan.folder = folder;
    plan.sha256 = json.require("plan_sha256", kExpected).string(kExpected);
    plan.manifest_folder = json.require("manifest_folder", kExpected).string(kExpected);
    plan.scenes = json.require("scenes", kExpected).unsigned_integer();
    plan.items = json.require("items", kExpected).unsigned_integer();
    for (const JsonReader& row : json.require("shards", kExpected).items(kExpected)) {
        const std::vector<JsonReader> numbers = row.items(kExpected);
        if (numbers.size() != 3) row.fail(kExpected);
        ShardRange shard{.first_scene = numbers[0].unsigned_integer(),
                         .end_scene = plan.scenes,
                         .first_item = numbers[1].unsigned_integer(),
                         .end_item = plan.items,
                         .offset = numbers[2].unsigned_integer()};
        if (!plan.shards.empty()) {
            ShardRange& previous = plan.shards.back();
            previous.end_scene = shard.first_scene;
            previous.end_item = shard.first_item;
        }
        plan.shards.push_back(shard);
    }

    const std::string lines = (folder / kLines).string();
    std::ifstream stream(lines, std::ios::binary);
    std::string line;
    if (!std::getline(stream, line))
        throw InputError(lines, "", std::string("cannot be read; ") + kExpected);
    const JsonValue first = parse_json(line, lines);
    const JsonReader settings(first, lines);
    const JsonReader version = settings.require("version", kExpected);
    if (version.string(kExpected) != AULA_VERSION)
        version.fail("was planned with Aula " + version.string(kExpected) +
                     "; expected a plan of " + AULA_VERSION + ", the version of this program");
    plan.settings = read_settings(settings);
    return plan;
}

PlanReader::PlanReader(const Plan& plan, const ShardRange& shard)
    : file_(plan.folder / kLines),
      stream_(file_, std::ios::binary),
      left_(shard.end_scene - shard.first_scene) {
    stream_.seekg(static_cast<std::streamoff>(shard.offset));
}

std::optional<PlannedScene> PlanReader::next() {
    if (left_ == 0) return std::nullopt;
    --left_;
    std::string line;
    if (!std::getline(stream_, line))
        throw InputError(file_.string(), "", std::string("ends too early; ") + kExpected);
    return read_scene_line(line, file_.string());
}

}  // namespace aula
