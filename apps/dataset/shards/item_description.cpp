#include "apps/dataset/shards/item_description.h"

#include <utility>
#include <vector>

#include "apps/dataset/base/json_values.h"
#include "apps/dataset/base/sha256.h"
#include "apps/output/json_text.h"

namespace aula {

namespace {

/// The end of an item's description.
std::string seal(const std::string& text, const std::string& wav) {
    Sha256 hash;
    hash.add(text);
    hash.add(wav);
    return ", \"item_sha256\": \"" + hash.hex() + "\"}\n";
}

}  // namespace

JsonValue::Object item_members(const Plan& plan, const PlannedScene& planned, std::uint64_t item) {
    return {{"item", json_value(item)},
            {"scene", json_value(planned.index)},
            {"seed", json_value(planned.seed)},
            {"plan_sha256", json_value(plan.sha256)},
            {"version", json_value(std::string(AULA_VERSION))},
            {"licence", json_value(plan.settings.licence)},
            {"geometry", json_value(planned.geometry)},
            {"materials", json_value(planned.materials)}};
}

JsonValue::Object response_members(const Plan& plan, const PlannedScene& planned,
                                   std::uint64_t item) {
    const DatasetSettings& settings = plan.settings;
    const std::size_t index = planned.receiver_of(item);
    const PlannedPose& receiver = planned.receivers[index];
    const std::vector<Pose> poses = microphone_poses(planned, settings);
    JsonValue::Array microphones;
    for (std::size_t m = 0; m < settings.array.size(); ++m)
        microphones.push_back(json_value(poses[index * settings.array.size() + m].position));
    return {
        {"source", planned.sources[planned.source_of(item)]},
        {"receiver", json_value(JsonValue::Object{{"position", json_value(receiver.position)},
                                                  {"yaw_deg", json_value(receiver.yaw_deg)},
                                                  {"pitch_deg", json_value(receiver.pitch_deg)}})},
        {"format", json_value(format_name(settings.format))},
        {"sample_rate_hz", json_value(static_cast<std::uint64_t>(settings.sample_rate_hz))},
        {"channels", json_value(std::uint64_t{settings.channels()})},
        {"microphones", json_value(std::move(microphones))}};
}

std::string sealed_json(JsonValue::Object members, const std::string& wav) {
    std::string text = json_line(json_value(std::move(members)));
    text.pop_back();  // the brace
    return text + seal(text, wav);
}

bool is_intact(const std::string& json, const std::string& wav) {
    static const std::size_t length = seal({}, {}).size();
    if (json.size() < length) return false;
    const std::string text = json.substr(0, json.size() - length);
    return json == text + seal(text, wav);
}

}  // namespace aula
