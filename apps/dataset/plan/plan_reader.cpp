#include "apps/dataset/plan/plan_reader.h"

#include <algorithm>
#include <utility>

#include "apps/dataset/base/sha256.h"
#include "aula/exception.h"
#include "engine/input/json_reader.h"
#include "engine/input/names.h"

namespace aula {

namespace {

namespace fs = std::filesystem;

constexpr const char* kExpected = Plan::kExpected;

[[noreturn]] void fail_changed(const std::string& file) {
    throw InputError(file, "",
                     "is not what plan.json was made with; expected the scenes of that plan");
}

std::uint64_t read_count(const JsonReader& json, std::uint64_t min, std::uint64_t max) {
    const std::uint64_t number = json.unsigned_integer();
    if (number < min || number > max)
        json.fail(std::to_string(number) + " is out of range; expected " + std::to_string(min) +
                  " to " + std::to_string(max));
    return number;
}

std::string read_hash(const JsonReader& json) {
    std::string hash = json.string(kExpected);
    if (!is_sha256(hash)) json.fail("is not a SHA-256; expected 64 hexadecimal digits");
    return hash;
}

/// Rows of the first scene, first item, offset and hash of each shard.
void read_shards(const JsonReader& json, Plan& plan) {
    constexpr std::uint64_t kLargestFile = std::uint64_t{1} << 62U;
    for (const JsonReader& row : json.items(kExpected)) {
        const std::vector<JsonReader> numbers = row.items(kExpected);
        if (numbers.size() != 4)
            row.fail(std::to_string(numbers.size()) + " elements; expected " + kExpected);
        plan.shards.push_back({.first_scene = read_count(numbers[0], 0, plan.scenes),
                               .end_scene = plan.scenes,
                               .first_item = read_count(numbers[1], 0, plan.items),
                               .end_item = plan.items,
                               .offset = read_count(numbers[2], 0, kLargestFile),
                               .sha256 = read_hash(numbers[3])});
        if (plan.shards.size() == 1) continue;
        ShardRange& previous = plan.shards.end()[-2];
        previous.end_scene = plan.shards.back().first_scene;
        previous.end_item = plan.shards.back().first_item;
        if (plan.shards.back().offset <= previous.offset)
            row.fail("its offset does not follow that of the previous shard; expected " +
                     std::string(kExpected));
    }
    if (plan.shards.empty() || plan.shards[0].first_scene != 0 || plan.shards[0].first_item != 0)
        json.fail(std::string("does not begin with the first scene; expected ") + kExpected);
    for (const ShardRange& shard : plan.shards) {
        // Each scene has at least one item.
        const std::uint64_t scenes = shard.end_scene - shard.first_scene;
        const std::uint64_t items = shard.end_item - shard.first_item;
        if (shard.end_scene <= shard.first_scene || shard.end_item <= shard.first_item ||
            items < scenes || items > scenes * kMostPairs)
            json.fail("scenes " + std::to_string(shard.first_scene) + " to " +
                      std::to_string(shard.end_scene) + " with items " +
                      std::to_string(shard.first_item) + " to " + std::to_string(shard.end_item) +
                      "; expected " + kExpected);
    }
}

}  // namespace

Plan read_plan(const fs::path& folder) {
    const std::string name = (folder / Plan::kFile).string();
    const JsonValue value = parse_json(read_regular_file(name, Plan::kMostBytes, kExpected), name);
    const JsonReader json(value, name);
    Plan plan;
    plan.folder = folder;
    plan.sha256 = read_hash(json.require("plan_sha256", kExpected));
    plan.manifest_folder = json.require("manifest_folder", kExpected).string(kExpected);
    plan.scenes = read_count(json.require("scenes", kExpected), 1, kMostScenes);
    plan.items =
        read_count(json.require("items", kExpected), plan.scenes, plan.scenes * kMostPairs);
    plan.empty_scenes = read_count(json.require("empty_scenes", kExpected), 0, plan.scenes);
    read_shards(json.require("shards", kExpected), plan);

    PlanLines lines(plan);
    const std::optional<std::string> line = lines.next();
    if (!line) throw InputError(lines.name(), "", std::string("is empty; expected ") + kExpected);
    const JsonValue first = parse_json(*line, lines.name());
    const JsonReader settings(first, lines.name());
    const JsonReader version = settings.require("version", kExpected);
    if (version.string(kExpected) != AULA_VERSION)
        version.fail("was planned with Aula " + quoted(version.string(kExpected)) +
                     "; expected a plan of " + AULA_VERSION + ", the version of this program");
    if (settings.require("scenes", kExpected).unsigned_integer() != plan.scenes ||
        lines.offset() != plan.shards[0].offset)
        fail_changed(lines.name());
    plan.settings = read_settings(settings);
    return plan;
}

void check_scenes(const Plan& plan) {
    PlanLines lines(plan);
    Sha256 hash;
    std::uint64_t last = 0;
    for (std::uint64_t at = 0; const auto line = lines.next(); at = lines.offset()) {
        hash.add(*line);
        hash.add("\n");
        last = at;
    }
    if (hash.hex() != plan.sha256) fail_changed(lines.name());

    const auto scene_at = [&](std::uint64_t offset) {
        lines.seek(offset);
        const std::optional<std::string> line = lines.next();
        if (!line) fail_changed(lines.name());
        return read_scene_line(*line, lines.name());
    };
    for (const ShardRange& shard : plan.shards) {
        const PlannedScene scene = scene_at(shard.offset);
        if (scene.index != shard.first_scene || scene.first_item != shard.first_item)
            fail_changed(lines.name());
    }
    const PlannedScene scene = scene_at(last);
    if (scene.index + 1 != plan.scenes || scene.first_item + scene.items != plan.items)
        fail_changed(lines.name());
}

PlanLines::PlanLines(const Plan& plan)
    : name_(plan.lines_file().string()), file_(name_, kExpected) {}

std::optional<std::string> PlanLines::next() {
    // The first line has the settings of a manifest of at most 16 MiB, another one up to 20,000
    // poses of about 100 bytes and the materials of that manifest.
    constexpr std::uint64_t kLongest = std::uint64_t{64} << 20U;
    constexpr std::uint64_t kPart = std::uint64_t{64} << 10U;
    std::string line;
    for (;;) {
        if (next_ < buffer_at_ || next_ >= buffer_at_ + buffer_.size()) {
            buffer_at_ = next_;
            buffer_ = file_.read(next_, kPart);
        }
        const std::string_view rest =
            std::string_view(buffer_).substr(static_cast<std::size_t>(next_ - buffer_at_));
        if (rest.empty()) break;
        const std::size_t end = std::min(rest.find('\n'), rest.size());
        line += rest.substr(0, end);
        next_ += end;
        if (end < rest.size()) {
            ++next_;
            return line;
        }
        if (line.size() > kLongest)
            throw InputError(name_, "",
                             "has a line of more than " + std::to_string(kLongest) +
                                 " bytes; expected " + kExpected);
    }
    if (line.empty()) return std::nullopt;
    return line;
}

PlanReader::PlanReader(const Plan& plan, const ShardRange& shard)
    : lines_(plan),
      scene_(shard.first_scene),
      end_scene_(shard.end_scene),
      item_(shard.first_item),
      end_item_(shard.end_item) {
    Sha256 hash;
    const auto add_line = [&] {
        const std::optional<std::string> line = lines_.next();
        if (!line) fail_changed(lines_.name());
        hash.add(*line);
        hash.add("\n");
    };
    add_line();
    lines_.seek(shard.offset);
    for (std::uint64_t scene = scene_; scene < end_scene_; ++scene) add_line();
    if (hash.hex() != shard.sha256) fail_changed(lines_.name());
    lines_.seek(shard.offset);
}

std::optional<PlannedScene> PlanReader::next() {
    if (scene_ == end_scene_) return std::nullopt;
    const std::optional<std::string> line = lines_.next();
    if (!line) fail_changed(lines_.name());
    PlannedScene scene = read_scene_line(*line, lines_.name());
    if (scene.index != scene_ || scene.first_item != item_) fail_changed(lines_.name());
    ++scene_;
    item_ += scene.items;
    if (scene_ == end_scene_ && item_ != end_item_) fail_changed(lines_.name());
    return scene;
}

}  // namespace aula
