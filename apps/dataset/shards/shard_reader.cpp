#include "apps/dataset/shards/shard_reader.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "apps/dataset/base/json_values.h"
#include "apps/dataset/base/sha256.h"
#include "apps/dataset/base/wav_bytes.h"
#include "apps/dataset/shards/item_description.h"
#include "apps/output/json_text.h"
#include "apps/output/printable.h"
#include "aula/exception.h"
#include "engine/input/json_reader.h"
#include "engine/scene/scene_values.h"

namespace aula {

namespace {

constexpr const char* kMember = "a member of an item";
constexpr const char* kShard = "a shard of the plan in its folder";

/// A description repeats parts of a line of the plan, and has up to 20 numbers for each of 1024
/// microphones.
constexpr std::uint64_t kLargestJson = std::uint64_t{64} << 20U;

/// The reason of an error names files; a line in a terminal.
constexpr std::size_t kLongestError = 16384;

/// The longest response: the time of direct sound over 20 km, which is above the longest decay.
std::uint64_t most_samples(const DatasetSettings& settings) {
    constexpr double kLongestDelay_s = 60;
    static_assert(kLongestDelay_s > static_cast<double>(Simulation::kMaxIrLength_s));
    return static_cast<std::uint64_t>(kLongestDelay_s * settings.sample_rate_hz);
}

/// True for the member "000123.json" or "000123.wav" of an item.
bool is_member(const TarMember& member, std::uint64_t item, const char* extension) {
    return member.name == Plan::item_name(item) + extension;
}

/// Throws InputError unless an item's description is of the plan.
void check_plan(const Plan& plan, const std::string& json, const std::string& name) {
    const JsonValue value = parse_json(json, name);
    const JsonReader hash = JsonReader(value, name).require("plan_sha256", "the hash of the plan");
    if (hash.string("the hash of the plan") != plan.sha256)
        hash.fail(std::string("is of another plan; expected ") + kShard);
}

/// Throws InputError unless the members of an item that its plan determines are so.
void check_planned(const JsonReader& json, const JsonValue::Object& planned) {
    for (const JsonMember& member : planned) {
        const JsonReader found = json.require(member.key, kMember);
        if (json_line(found.value()) != json_line(member.value))
            found.fail("is not that of the plan; expected what aula dataset run writes");
    }
}

/// Values of the octave bands from 63 Hz to 8 kHz for each microphone; NaN for null.
std::vector<std::array<double, kBandCount>> read_octaves(const JsonReader& json,
                                                         std::size_t microphones) {
    constexpr NumberRange kTime_s{0, 1e9, true, "seconds, or null"};
    std::vector<std::array<double, kBandCount>> values;
    for (const JsonReader& row : json.items(kMember)) {
        const std::vector<JsonReader> octaves = row.items(kMember);
        if (octaves.size() != kBandCount)
            row.fail(std::to_string(octaves.size()) + " values; expected those of 8 octaves");
        std::array<double, kBandCount>& of_microphone = values.emplace_back();
        for (std::size_t band = 0; band < kBandCount; ++band) {
            const bool absent = std::holds_alternative<std::monostate>(octaves[band].value().value);
            of_microphone[band] =
                absent ? std::numeric_limits<double>::quiet_NaN() : octaves[band].number(kTime_s);
        }
    }
    if (values.size() != microphones)
        json.fail(std::to_string(values.size()) + " microphones; expected " +
                  std::to_string(microphones));
    return values;
}

}  // namespace

ShardReader::ShardReader(const Plan& plan, std::size_t shard)
    : plan_(plan),
      range_(plan.shards.at(shard)),
      tar_(plan.shard_file(shard)),
      ahead_(tar_.next()),
      item_(range_.first_item) {}

bool ShardReader::next() {
    const auto fail = [&](const std::string& problem) {
        throw InputError(tar_.name(), "", problem + "; expected " + kShard);
    };
    if (item_ == range_.end_item) {
        if (ahead_) fail("has further items");
        return false;
    }
    if (!ahead_ || !is_member(*ahead_, item_, ".json") || ahead_->size > kLargestJson)
        fail("has no item " + std::to_string(item_));
    json_ = std::move(*ahead_);
    if (item_ == range_.first_item)
        check_plan(plan_, tar_.read(json_), tar_.name() + ": item " + std::to_string(item_));
    wav_.reset();
    ahead_ = tar_.next();
    if (ahead_ && is_member(*ahead_, item_, ".wav")) {
        wav_ = std::move(ahead_);
        ahead_ = tar_.next();
    }
    ++item_;
    return true;
}

std::uint64_t ShardReader::samples() const {
    const std::uint64_t samples = wav_ ? wav_length(wav_->size, plan_.settings.channels()) : 0;
    return samples <= most_samples(plan_.settings) ? samples : 0;
}

const PlannedScene& ShardReader::planned() {
    if (!scenes_) scenes_.emplace(plan_, range_);
    while (!scene_ || item() >= scene_->first_item + scene_->items) {
        scene_ = scenes_->next();
        // The numbers of the scenes end with those of the shard.
        if (!scene_) throw InputError(tar_.name(), "", std::string("expected ") + kShard);
    }
    return *scene_;
}

ShardItem ShardReader::read() {
    const std::string name = tar_.name() + ": item " + std::to_string(item());
    const PlannedScene& scene = planned();
    if (wav_ && samples() == 0)
        throw InputError(name, "",
                         "a response of " + std::to_string(wav_->size) + " bytes; expected " +
                             std::to_string(plan_.settings.channels()) + " channels of 1 to " +
                             std::to_string(most_samples(plan_.settings)) + " samples");
    ShardItem item;
    item.index = this->item();
    item.scene = scene.index;
    item.seed = scene.seed;
    item.json = tar_.read(json_);
    if (wav_) item.wav = tar_.read(*wav_);
    if (!is_intact(item.json, item.wav))
        throw InputError(name, "",
                         "is damaged; expected the bytes of aula dataset run (delete the shard "
                         "and compute it again)");
    const JsonValue value = parse_json(item.json, name);
    const JsonReader json(value, name);
    check_planned(json, item_members(plan_, scene, item.index));
    if (wav_) {
        read_response(json, item);
    } else {
        json.allow_keys({"item", "scene", "seed", "plan_sha256", "version", "licence", "geometry",
                         "materials", "error", "item_sha256"});
        const JsonReader error = json.require("error", "an error");
        item.error = error.string("an error");
        if (item.error.empty() || item.error.size() > kLongestError ||
            item.error != printable_line(item.error))
            error.fail("is not a reason; expected one line");
    }
    // Comments, and other texts of the same values, are not JSON for all readers.
    if (json_line(value) + "\n" != item.json)
        json.fail("is not written as by aula dataset run; expected its bytes");
    return item;
}

void ShardReader::read_response(const JsonReader& json, ShardItem& item) {
    constexpr const char* kHash = "64 hexadecimal digits";
    const DatasetSettings& settings = plan_.settings;
    const PlannedScene& scene = *scene_;
    if (!scene.error.empty()) json.fail("has a response; expected the error of its scene");
    check_planned(json, response_members(plan_, scene, item.index));
    std::vector<std::string> keys{"item",        "scene",    "seed",           "plan_sha256",
                                  "version",     "licence",  "geometry",       "source",
                                  "materials",   "receiver", "format",         "scene_sha256",
                                  "frames",      "channels", "sample_rate_hz", "samples",
                                  "microphones", "T30",      "item_sha256"};
    if (!settings.frames) keys.emplace_back("T30_error");
    json.allow_keys(keys);

    item.box_m = scene.box_m();
    if (!item.box_m)
        item.scene_file =
            json.require("geometry", kMember).require("file", kMember).string(kMember);
    item.source = read_pose(json.require("source", kMember));
    item.receiver = read_pose(json.require("receiver", kMember));
    const JsonReader hash = json.require("scene_sha256", kHash);
    item.scene_sha256 = hash.string(kHash);
    if (!is_sha256(item.scene_sha256)) hash.fail(std::string("expected ") + kHash);
    item.t30_s = read_octaves(json.require("T30", kMember), settings.array.size());
    if (!settings.frames) read_octaves(json.require("T30_error", kMember), settings.array.size());
    json.require("frames", kMember)
        .integer(settings.frames.value_or(1),
                 settings.frames.value_or(std::numeric_limits<int>::max()));
    const JsonReader samples = json.require("samples", kMember);
    item.samples = samples.unsigned_integer();
    if (!is_wav(item.wav, settings.channels(), item.samples, settings.sample_rate_hz))
        samples.fail("the response is not a WAV file of " + std::to_string(settings.channels()) +
                     " channels, " + std::to_string(item.samples) +
                     " finite samples; expected the bytes of aula dataset run");
}

std::optional<ShardContents> find_shard(const Plan& plan, std::size_t shard) {
    ShardContents contents;
    try {
        ShardReader reader(plan, shard);
        while (reader.next()) ++(reader.has_response() ? contents.responses : contents.errors);
    } catch (const InputError&) {
        return std::nullopt;
    }
    return contents;
}

}  // namespace aula
