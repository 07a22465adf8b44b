#include "apps/dataset/shards/item.h"

#include <algorithm>
#include <span>
#include <utility>

#include "apps/dataset/base/json_values.h"
#include "apps/dataset/base/wav_bytes.h"
#include "apps/dataset/shards/item_description.h"
#include "apps/output/printable.h"
#include "aula/exception.h"
#include "aula/measurement.h"

namespace aula {

namespace {

Item failed_item(const Plan& plan, const PlannedScene& planned, std::uint64_t index,
                 const std::string& reason) {
    JsonValue::Object json = item_members(plan, planned, index);
    // One line of UTF-8, whatever names of files the reason contains.
    json.push_back({"error", json_value(printable_line(reason))});
    return {index, sealed_json(std::move(json), {}), {}};
}

/// Values of the octave bands from 63 Hz to 8 kHz; null where the decay is not sufficient.
JsonValue octaves_json(const PairParameters& parameters, bool errors) {
    JsonValue::Array list;
    for (std::size_t band = 0; band < kBandCount; ++band) {
        const MeasuredValue& value = parameters.octave(AcousticParameter::t30, band);
        const std::optional<double>& number = errors ? value.standard_error : value.value;
        // Six digits: more than the result is certain of.
        list.push_back(number ? json_value(static_cast<float>(*number)) : JsonValue{});
    }
    return json_value(std::move(list));
}

/// The results of the microphones of one receiver.
class ReceiverResults {
 public:
    ReceiverResults(const Plan& plan, const PlannedScene& planned, const Measurement& measurement,
                    std::uint64_t item)
        : settings_(plan.settings),
          measurement_(measurement),
          source_(planned.source_of(item)),
          first_(planned.receiver_of(item) * settings_.array.size()) {}

    /// Why the source is not audible at the first microphone.
    const std::string& inaudible() const {
        return measurement_.inaudible[measurement_.pair(source_, first_)];
    }

    bool audible() const {
        bool any = false;
        for (std::size_t m = 0; m < settings_.array.size(); ++m)
            any = any || measurement_.audible[measurement_.pair(source_, first_ + m)] != 0;
        return any;
    }

    void describe(JsonValue::Object& json) const {
        JsonValue::Array t30, errors;
        for (std::size_t m = 0; m < settings_.array.size(); ++m) {
            const std::size_t pair = measurement_.pair(source_, first_ + m);
            t30.push_back(octaves_json(measurement_.parameters[pair], false));
            errors.push_back(octaves_json(measurement_.parameters[pair], true));
        }
        json.push_back({"T30", json_value(std::move(t30))});
        if (!settings_.frames) json.push_back({"T30_error", json_value(std::move(errors))});
        json.push_back({"frames", json_value(static_cast<std::uint64_t>(measurement_.frames))});
    }

    std::vector<std::vector<float>> channels(const ImpulseResponses& responses) const {
        std::vector<std::vector<float>> channels;
        for (std::size_t m = 0; m < settings_.array.size(); ++m)
            for (auto& channel : responses.response(source_, first_ + m))
                channels.push_back(std::move(channel));
        std::size_t longest = 0;
        for (const auto& channel : channels) longest = std::max(longest, channel.size());
        for (auto& channel : channels) channel.resize(longest);
        return channels;
    }

 private:
    const DatasetSettings& settings_;
    const Measurement& measurement_;
    std::size_t source_;
    std::size_t first_;  ///< of its microphones
};

std::vector<Item> items_of(const Plan& plan, const PlannedScene& planned, const Scene& scene,
                           const Measurement& measurement) {
    const DatasetSettings& settings = plan.settings;
    const ImpulseResponses responses(
        measurement,
        {.sample_rate_hz = double(settings.sample_rate_hz), .output = settings.format});
    const std::string hash = scene_hash(scene);
    std::vector<Item> items;
    for (std::uint64_t i = planned.first_item; i < planned.first_item + planned.items; ++i) {
        const ReceiverResults results(plan, planned, measurement, i);
        if (!results.audible()) {
            items.push_back(
                failed_item(plan, planned, i, "the source is not audible: " + results.inaudible()));
            continue;
        }
        const std::vector<std::vector<float>> channels = results.channels(responses);
        JsonValue::Object json = item_members(plan, planned, i);
        json.push_back({"scene_sha256", json_value(hash)});
        for (JsonMember& member : response_members(plan, planned, i))
            json.push_back(std::move(member));
        json.push_back({"samples", json_value(std::uint64_t{channels[0].size()})});
        results.describe(json);
        std::string wav = wav_bytes(channels, settings.sample_rate_hz);
        std::string line = sealed_json(std::move(json), wav);
        items.push_back({i, std::move(line), std::move(wav)});
    }
    return items;
}

}  // namespace

std::optional<std::vector<Item>> compute_items(const Plan& plan, const PlannedScene& planned,
                                               SceneFiles& files,
                                               const std::function<bool()>& continues) {
    std::string error = planned.error;
    try {
        if (error.empty()) {
            const DatasetSettings& settings = plan.settings;
            const Scene scene = build_scene(planned, settings, files);
            const auto measurement =
                measure(scene, scene.sources, microphone_poses(planned, settings),
                        {.frames = settings.frames,
                         .limits = settings.limits,
                         .max_frames = settings.max_frames,
                         .progress = [&](double) { return continues(); }});
            if (!measurement) return std::nullopt;
            return items_of(plan, planned, scene, *measurement);
        }
    } catch (const InputError& wrong) {
        error = wrong.what();
    }
    std::vector<Item> items;
    for (std::uint64_t i = planned.first_item; i < planned.first_item + planned.items; ++i)
        items.push_back(failed_item(plan, planned, i, error));
    return items;
}

}  // namespace aula
