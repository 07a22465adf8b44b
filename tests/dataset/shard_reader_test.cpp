#include "apps/dataset/shards/shard_reader.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <limits>

#include "apps/dataset/base/sha256.h"
#include "aula/exception.h"
#include "tests/dataset/forged_shard.h"
#include "tests/dataset/small_dataset.h"

namespace {

using namespace aula;
using namespace aula::test;
namespace fs = std::filesystem;

constexpr std::size_t kHeader = 58;  // of a WAV file of 32-bit floating point

/// The error of reading all items of a shard.
std::string error_of(const fs::path& folder) {
    try {
        const Plan plan = read_plan(folder);
        ShardReader reader(plan, 0);
        while (reader.next()) reader.read();
    } catch (const InputError& error) {
        return error.what();
    }
    return {};
}

/// Replaces the number of samples that the description and the header give.
void claim_samples(std::string& json, std::string& wav, std::uint32_t samples) {
    const std::size_t at = json.find("\"samples\": ") + 11;
    json.replace(at, json.find(',', at) - at, std::to_string(samples));
    std::memcpy(wav.data() + 46, &samples, sizeof(samples));
}

}  // namespace

TEST_CASE("an item is read only if every member agrees with the plan and its response") {
    const TemporaryFolder folder;
    const fs::path out = make_dataset(folder, box_manifest(1), "out", 1);
    const fs::path shard = out / "shard-00000.tar";
    const std::string honest = read_file(shard);
    REQUIRE(error_of(out).empty());
    forge_shard(shard, [](std::size_t, std::string&, std::string&) {});
    CHECK(read_file(shard) == honest);

    struct Forged {
        const char* part;     ///< of the description of item 1
        const char* instead;  ///< what replaces it
        const char* place;
    };
    const Forged forged[] = {
        {"\"item\": 1", "\"item\": 0", "/item"},
        {"\"item\": 1", "\"item\": \"1\"", "/item"},
        {"\"item\": 1, ", "", "/item: missing"},
        {"\"scene\": 0", "\"scene\": 1", "/scene"},
        {"\"seed\": ", "\"seed\": 1", "/seed"},
        {"\"plan_sha256\": \"", "\"plan_sha256\": \"0", "/plan_sha256"},
        {"\"licence\": \"CC0", "\"licence\": \"=CC0", "/licence"},
        {"\"version\": \"", "\"version\": \"9", "/version"},
        {"\"box\": [", "\"box\": [[], ", "/geometry"},
        {"\"materials\": {", "\"materials\": {\"x\": 1, ", "/materials"},
        {"\"materials\": {", "\"more\": 1, \"materials\": {", "/more: unknown key"},
        {"\"materials\": {", "\"error\": \"x\", \"materials\": {", "/error: unknown key"},
        {"\"scene_sha256\": \"", "\"scene_sha256\": \"0", "/scene_sha256"},
        {"\"directivity\": \"omni\"", "\"directivity\": \"talker\"", "/source"},
        {"\"receiver\": {\"position\": [", "\"receiver\": {\"position\": [1", "/receiver"},
        {"\"format\": \"mono\"", "\"format\": \"foa\"", "/format"},
        {"\"sample_rate_hz\": 8000", "\"sample_rate_hz\": 16000", "/sample_rate_hz"},
        {"\"channels\": 1", "\"channels\": 2", "/channels"},
        {"\"samples\": ", "\"samples\": 1", "/samples"},
        {"\"samples\": ", "\"samples\": -", "/samples"},
        {"\"microphones\": [", "\"microphones\": [[0, 0, 0], ", "/microphones: is not that of"},
        {"\"T30\": [[", "\"T30\": [[null, ", "/T30/0: 9 values"},
        {"\"T30\": [", "\"T30\": [[], ", "/T30/0: 0 values"},
        {"\"T30\": [", "\"T30\": [1, ", "/T30/0"},
        {"\"T30\": [[", "\"T30\": [[{}, ", "/T30/0"},
        {"\"frames\": 1", "\"frames\": 0", "/frames"},
        {"\"frames\": 1", "\"frames\": 2", "/frames"},
        {"{\"item\"", "{ \"item\"", "is not written as by aula dataset run"},
        {"{\"item\"", "{/* */\"item\"", "is not written as by aula dataset run"},
        {"\"item\"", "\"seed\": 1, \"item\"", "/seed: duplicate key"},
    };
    for (const Forged& f : forged) {
        INFO(f.part << " -> " << f.instead);
        folder.write("out/shard-00000.tar", honest);
        forge_shard(shard, [&](std::size_t item, std::string& json, std::string&) {
            if (item == 1) replace_part(json, f.part, f.instead);
        });
        const std::string error = error_of(out);
        INFO(error);
        CHECK(error.find("shard-00000.tar: item 1: ") != std::string::npos);
        CHECK(error.find(f.place) != std::string::npos);
    }

    const auto refused = [&](const auto& change) {
        folder.write("out/shard-00000.tar", honest);
        forge_shard(shard, [&](std::size_t item, std::string& json, std::string& wav) {
            if (item == 1) change(json, wav);
        });
        const std::string error = error_of(out);
        INFO(error);
        CHECK(error.find("shard-00000.tar: item 1: ") != std::string::npos);
    };
    refused([](std::string&, std::string& wav) { wav.clear(); });
    refused([](std::string&, std::string& wav) { wav.resize(kHeader - 1); });
    refused([](std::string&, std::string& wav) { wav.resize(wav.size() - 1); });
    refused([](std::string&, std::string& wav) { wav.resize(wav.size() - sizeof(float)); });
    refused([](std::string&, std::string& wav) { wav.append(sizeof(float), '\0'); });
    refused([](std::string&, std::string& wav) { wav[24] = 1; });  // sample rate
    refused([](std::string& json, std::string& wav) { claim_samples(json, wav, 0); });
    // Longer than any response at this rate, in one file.
    refused([](std::string& json, std::string& wav) {
        constexpr std::uint32_t kSamples = 60 * 8000 + 1;
        wav.resize(kHeader + kSamples * sizeof(float));
        claim_samples(json, wav, kSamples);
    });
    for (const float value :
         {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()})
        refused([&](std::string&, std::string& wav) {
            std::memcpy(wav.data() + wav.size() - sizeof(value), &value, sizeof(value));
        });
}

TEST_CASE("an item with an error has one line as its reason, and no response") {
    const TemporaryFolder folder;
    std::string manifest = box_manifest(1);
    replace_part(manifest, "\"receivers\": {", R"("receivers": {"wall_clearance_m": 100, )");
    folder.write("manifest.json", manifest);
    const fs::path out = folder.path() / "out";
    run_dataset({"plan", folder.path() / "manifest.json", "--out", out, "--shards", "1"});
    run_shards(out, 1);
    const fs::path shard = out / "shard-00000.tar";
    const std::string honest = read_file(shard);
    REQUIRE(error_of(out).empty());
    for (const char* const error :
         {"\"two\\u000alines\"", "\"\\u001b[31m\"", "\"\"", "1", "\"x\", \"more\": 1"}) {
        folder.write("out/shard-00000.tar", honest);
        forge_shard(shard, [&](std::size_t, std::string& json, std::string&) {
            json.replace(json.find("\"error\": ") + 9, std::string::npos, error);
        });
        INFO(error);
        CHECK(error_of(out).find("shard-00000.tar: item 0: /") != std::string::npos);
    }
    // A response of a scene that has none.
    folder.write("out/shard-00000.tar", honest);
    forge_shard(shard, [](std::size_t, std::string& json, std::string& wav) {
        json.resize(json.find(", \"error\""));
        wav.resize(kHeader + 4);
    });
    CHECK(error_of(out).find("item 0: has a response; expected the error") != std::string::npos);

    // Spreadsheets compute no formula of the table of errors.
    folder.write("out/shard-00000.tar", honest);
    forge_shard(shard, [](std::size_t item, std::string& json, std::string&) {
        if (item == 0)
            json.replace(json.find("\"error\": ") + 9, std::string::npos,
                         R"("=cmd|'/C calc'!A0, \"x\"")");
    });
    require_dataset({"merge", out, "--to", "wav"});
    CHECK(read_file(out / "wav/errors.csv") ==
          "item,error\n0,\"'=cmd|'/C calc'!A0, \"\"x\"\"\"\n1,\"no position has these "
          "clearances\"\n");
}

TEST_CASE("plan.json must divide the scenes of plan.jsonl") {
    const TemporaryFolder folder;
    const fs::path out = make_dataset(folder, box_manifest(3), "out", 2);
    const std::string plan = read_file(out / "plan.json");
    struct Forged {
        const char* part;
        const char* instead;
        const char* message;
    };
    const Forged forged[] = {
        {"\"scenes\": 3", "\"scenes\": 4", "plan.jsonl: is not what plan.json was made with"},
        {"\"scenes\": 3", "\"scenes\": 0", "plan.json: /scenes"},
        {"\"scenes\": 3", "\"scenes\": 18446744073709551615", "plan.json: /scenes"},
        {"\"scenes\": 3", "\"scenes\": 1", "plan.json: /shards"},
        {"\"items\": 6", "\"items\": 7", "plan.jsonl: is not what plan.json was made with"},
        {"\"items\": 6", "\"items\": 2", "plan.json: /items"},
        {"\"items\": 6", "\"items\": 300001", "plan.json: /items"},
        {"\"empty_scenes\": 0", "\"empty_scenes\": 4", "plan.json: /empty_scenes"},
        {"[0, 0, ", "[0, 1, ", "plan.json: /shards"},
        {"[0, 0, ", "[1, 0, ", "plan.json: /shards"},
        {"[0, 0, ", "[0, 0, 1", "plan.json"},
        {"[1, 2, ", "[2, 2, ", "plan.jsonl: is not what plan.json was made with"},
        {"[1, 2, ", "[1, 3, ", "plan.jsonl: is not what plan.json was made with"},
        {"[1, 2, ", "[0, 2, ", "plan.json: /shards"},
        {"[1, 2, ", "[1, 2, 1", "plan.jsonl: is not what plan.json was made with"},
        {"[1, 2, ", "[1, 2, 0, ", "plan.json: /shards/1: 5 elements"},
        {"\"shards\": [", "\"shards\": [], \"x\": [", "plan.json: /shards"},
        {"\"plan_sha256\": \"", "\"plan_sha256\": \"x", "plan.json: /plan_sha256"},
    };
    for (const Forged& f : forged) {
        INFO(f.part << " -> " << f.instead);
        std::string changed = plan;
        replace_part(changed, f.part, f.instead);
        folder.write("out/plan.json", changed);
        for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
                 {"status", out}, {"merge", out, "--to", "wav"}}) {
            const ProgramResult result = run_dataset(arguments);
            INFO(result.err);
            CHECK(result.status == 2);
            CHECK(result.err.find(f.message) != std::string::npos);
        }
    }
}

TEST_CASE("a task refuses a shard whose scenes have other numbers than plan.json says") {
    const TemporaryFolder folder;
    const std::string manifest = folder.write("manifest.json", box_manifest(2));
    const fs::path out = folder.path() / "out";
    require_dataset({"plan", manifest, "--out", out, "--shards", "1"});
    const std::string plan = read_file(out / "plan.json");
    const std::string lines = read_file(out / "plan.jsonl");
    struct Forged {
        const char* part;
        const char* instead;
    };
    for (const Forged& f :
         {Forged{"\"first_item\": 2", "\"first_item\": 1"}, Forged{"\"scene\": 1", "\"scene\": 2"},
          Forged{"\"items\": 2", "\"items\": 3"},
          Forged{"\"items\": 2", "\"items\": 18446744073709551615"},
          Forged{"\"box\": [", "\"box\": [1, "}, Forged{"\"box\": [", "\"box\": [-"},
          Forged{"\"geometry\": {", "\"geometry\": {\"file\": \"x\", "},
          Forged{"\"sources\": [{", "\"sources\": [{}, {"}}) {
        INFO(f.part << " -> " << f.instead);
        std::string changed = lines;
        const std::size_t second = changed.rfind("{\"scene\"");
        const std::size_t at = changed.find(f.part, second);
        REQUIRE(at != std::string::npos);
        changed.replace(at, std::string(f.part).size(), f.instead);
        std::string hashed = plan;
        for (int i = 0; i < 2; ++i) replace_part(hashed, sha256(lines), sha256(changed));
        folder.write("out/plan.jsonl", changed);
        folder.write("out/plan.json", hashed);
        const ProgramResult result = run_dataset({"run", out, "--shard", "0"});
        INFO(result.err);
        CHECK(result.status == 2);
        CHECK(result.err.find("plan.jsonl: ") != std::string::npos);
    }
}
