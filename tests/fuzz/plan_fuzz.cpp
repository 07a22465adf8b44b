#include <algorithm>

#include "apps/output/json_text.h"
#include "aula/exception.h"
#include "tests/fuzz/dataset_target.h"

using namespace aula;

namespace {

/// The value of a whole number up to a limit; 0 for others.
std::size_t number(const JsonValue& value, std::size_t most) {
    const auto* const number = std::get_if<std::uint64_t>(&value.value);
    return number == nullptr ? 0 : static_cast<std::size_t>(std::min<std::uint64_t>(*number, most));
}

/// plan.json with the hashes that `lines` have: an attacker computes them, too.
std::string repaired(const std::string& text, const std::string& lines) {
    JsonValue json;
    try {
        json = parse_json(text, Plan::kFile);
    } catch (const InputError&) {
        return text;
    }
    auto* const members = std::get_if<JsonValue::Object>(&json.value);
    if (members == nullptr) return text;
    const std::string settings = lines.substr(0, lines.find('\n') + 1);
    for (auto& [key, value] : *members) {
        if (key == "plan_sha256") value.value = sha256(lines);
        auto* const rows = std::get_if<JsonValue::Array>(&value.value);
        if (key != "shards" || rows == nullptr) continue;
        std::size_t end = lines.size();
        for (auto row = rows->rbegin(); row != rows->rend(); ++row) {
            auto* const shard = std::get_if<JsonValue::Array>(&row->value);
            if (shard == nullptr || shard->size() != 4) continue;
            const std::size_t offset = number((*shard)[2], end);
            (*shard)[3].value = sha256(settings + lines.substr(offset, end - offset));
            end = offset;
        }
    }
    return json_line(json);
}

}  // namespace

/// Reads plan.json and plan.jsonl, the two parts of an input.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    std::vector<std::string> parts =
        test::parts_of(std::string_view(reinterpret_cast<const char*>(data), size));
    if (parts.size() != 2) return 0;
    const std::string lines = test::with_version(parts[1]);
    test::fuzz_folder().write(Plan::kFile, repaired(parts[0], lines));
    test::fuzz_folder().write(Plan::kLines, lines);
    try {
        const Plan plan = read_plan(test::fuzz_folder().path());
        check_scenes(plan);
        SceneFiles files(plan.folder);
        std::uint64_t item = 0, scene = 0;
        for (const ShardRange& shard : plan.shards) {
            PlanReader reader(plan, shard);
            while (const auto planned = reader.next()) {
                test::expect(planned->index == scene++, "scenes are numbered");
                test::expect(planned->first_item == item, "items are numbered");
                item += planned->items;
                test::expect(read_scene_line(scene_line(*planned), "line").items == planned->items,
                             "a scene can be written");
                if (!planned->error.empty() || !planned->box_m()) continue;
                microphone_poses(*planned, plan.settings);
                const Scene built = build_scene(*planned, plan.settings, files);
                test::expect(built.sources.size() == planned->sources.size(), "sources");
            }
        }
        test::expect(scene == plan.scenes && item == plan.items, "all scenes are in shards");
    } catch (const InputError& error) {
        test::expect_one_line(error.what());
    }
    return 0;
}
