#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/dataset/base/sha256.h"
#include "apps/dataset/base/tar.h"
#include "apps/dataset/plan/plan_reader.h"
#include "tests/fuzz/fuzz_target.h"

namespace aula::test {

/// The text with the version of this program in place of that of the corpus.
inline std::string with_version(std::string text) {
    constexpr std::string_view kOfCorpus = R"("version": "0.1.0")";
    if (const std::size_t at = text.find(kOfCorpus); at != std::string::npos)
        text.replace(at, kOfCorpus.size(), R"("version": ")" AULA_VERSION "\"");
    return text;
}

/// The parts of an input, divided by lines "--".
inline std::vector<std::string> parts_of(std::string_view input) {
    constexpr std::string_view kDivider = "\n--\n";
    std::vector<std::string> parts;
    for (;;) {
        const std::size_t end = input.find(kDivider);
        parts.emplace_back(input.substr(0, end));
        if (end == input.npos) return parts;
        input.remove_prefix(end + kDivider.size());
    }
}

/// The plan of the corpora of shards, in fuzz_folder(): a box with a source, two receivers and two
/// microphones, and a scene without positions.
inline const Plan& fuzz_plan() {
    static const Plan plan = [] {
        const std::string settings =
            R"({"aula_plan": 1, "version": "0.1.0", "scenes": 2, "licence": "CC0-1.0", )"
            R"("seed": 1, "measurement": {"frames": 1}, "output": {"sample_rate_hz": 8000}, )"
            R"("array": [[0, 0.04, 0], [0, -0.04, 0]]})";
        const std::string lines =
            settings + "\n" +
            R"({"scene": 0, "first_item": 0, "items": 2, "seed": 4317239941654215, )"
            R"("geometry": {"box": [5, 4, 3]}, "materials": {"walls": {"absorption": [0.5, )"
            R"(0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5], "scattering": [0.2, 0.2, 0.2, 0.2, 0.2, )"
            R"(0.2, 0.2, 0.2]}, "floor": {"absorption": [0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, )"
            R"(0.5], "scattering": [0.2, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2]}, "ceiling": )"
            R"({"absorption": [0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5], "scattering": [0.2, )"
            R"(0.2, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2]}}, "sources": [{"name": "source-0", )"
            R"("position": [0.7508, 0.6732, 1.9471], "yaw_deg": 0, "pitch_deg": 0, )"
            R"("directivity": "omni"}], "receivers": [{"position": [0.6708, 2.6013, 1.0525], )"
            R"("yaw_deg": 0, "pitch_deg": 0}, {"position": [4.1995, 2.8432, 0.5124], )"
            R"("yaw_deg": 0, "pitch_deg": 0}]})"
            "\n"
            R"({"scene": 1, "first_item": 2, "items": 1, "seed": 8, "geometry": )"
            R"({"box": [1, 1, 1]}, "materials": {}, "error": "no position"})"
            "\n";
        fuzz_folder().write(Plan::kLines, lines);
        const JsonValue value = parse_json(settings, Plan::kLines);
        const std::string name = Plan::kLines;
        Plan made;
        made.folder = fuzz_folder().path();
        made.sha256 = sha256(lines);
        made.settings = read_settings(JsonReader(value, name));
        made.scenes = 2;
        made.items = 3;
        made.empty_scenes = 1;
        made.shards = {{.first_scene = 0,
                        .end_scene = 2,
                        .first_item = 0,
                        .end_item = 3,
                        .offset = settings.size() + 1,
                        .sha256 = made.sha256}};
        return made;
    }();
    return plan;
}

/// The bytes of an item in an archive.
inline std::string archived(const std::string& name, const std::string& content) {
    return tar_header(name, content.size()) + content + std::string(tar_padding(content.size()));
}

/// A description with the hash that it and its response have: an attacker computes it, too.
/// Without one at its end it remains as it is.
inline std::string resealed(std::string json, const std::string& wav) {
    constexpr std::string_view kSeal = ", \"item_sha256\": \"";
    const std::size_t at = json.rfind(kSeal);
    if (at == std::string::npos) return json;
    json.resize(at);
    Sha256 hash;
    hash.add(json);
    hash.add(wav);
    return json + std::string(kSeal) + hash.hex() + "\"}\n";
}

/// A description of the corpus with the hash and the version of the plan of fuzz_plan().
inline std::string of_plan(std::string json) {
    constexpr std::string_view kHash = R"("plan_sha256": ")";
    json = with_version(std::move(json));
    const std::size_t at = json.find(kHash);
    const std::string& sha256 = fuzz_plan().sha256;
    if (at != std::string::npos && json.size() >= at + kHash.size() + sha256.size())
        json.replace(at + kHash.size(), sha256.size(), sha256);
    return json;
}

}  // namespace aula::test
