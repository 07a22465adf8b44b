#include "apps/dataset/merge/merged_item.h"

#include <limits>
#include <utility>
#include <variant>

#include "apps/dataset/base/wav_bytes.h"
#include "engine/input/json_reader.h"
#include "engine/scene/scene_values.h"

namespace aula {

namespace {

constexpr const char* kMember = "a member of an item";

PlannedPose read_pose(const JsonReader& json) {
    constexpr NumberRange kAngle{-360, 360, true, "degrees"};
    return {read_point(json.require("position", kMember)),
            json.require("yaw_deg", kMember).number(kAngle),
            json.require("pitch_deg", kMember).number(kAngle)};
}

std::vector<double> read_octaves(const JsonReader& json) {
    std::vector<double> values;
    for (const JsonReader& item : json.items(kMember))
        values.push_back(item.is_number() ? item.number({})
                                          : std::numeric_limits<double>::quiet_NaN());
    if (values.size() != kBandCount) json.fail("expected values of 8 octaves");
    return values;
}

}  // namespace

std::vector<std::vector<float>> MergedItem::channels() const { return wav_channels(wav); }

MergedItem read_item(const TarReader& tar, const ItemMembers& members) {
    MergedItem item;
    Item read = read_intact_item(tar, members);
    item.index = read.index;
    item.json = std::move(read.json);
    item.wav = std::move(read.wav);
    const JsonValue value = parse_json(item.json, members.json.name);
    const JsonReader json(value, members.json.name);
    item.scene = json.require("scene", kMember).unsigned_integer();
    item.seed = json.require("seed", kMember).unsigned_integer();
    item.samples = json.require("samples", kMember).unsigned_integer();
    item.scene_sha256 = json.require("scene_sha256", kMember).string(kMember);
    item.source = read_pose(json.require("source", kMember));
    item.receiver = read_pose(json.require("receiver", kMember));
    for (const JsonReader& row : json.require("T30", kMember).items(kMember))
        item.t30_s.push_back(read_octaves(row));
    if (item.t30_s.empty()) json.fail("expected a microphone");
    item.geometry = std::get<JsonValue::Object>(json.require("geometry", kMember).value().value);
    return item;
}

}  // namespace aula
