// Shards and plans that somebody else wrote, with the right hashes.

#include <sys/stat.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>

#include "tests/dataset/forged_shard.h"
#include "tests/dataset/small_dataset.h"

namespace {

using namespace aula::test;
namespace fs = std::filesystem;

/// A dataset of one scene with two items of two microphones.
fs::path small_dataset(const TemporaryFolder& folder) {
    return make_dataset(folder, box_manifest(1, R"("array": [[0, 0.04, 0], [0, -0.04, 0]],
                                           "output": {"sample_rate_hz": 8000})"),
                        "out", 1);
}

void require_refused(const ProgramResult& result, const std::string& message) {
    INFO(result.err);
    CHECK(result.status == 2);
    CHECK(result.out.empty());
    CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
    CHECK(result.err.find(message) != std::string::npos);
}

/// Merges to all formats, with and without an earlier result.
void require_no_merge(const fs::path& out, const std::string& message) {
    for (const char* const format : {"wav", "hdf5", "sofa"})
        require_refused(run_dataset({"merge", out, "--to", format}), message);
    CHECK(names_in(out) == std::vector<std::string>{"plan.json", "plan.jsonl", "shard-00000.tar"});
    const ProgramResult status = run_dataset({"status", out, "--missing", "--verify"});
    CHECK(status.status == 0);
    CHECK(status.out == "0\n");
}

constexpr std::size_t kHeader = 58;  // of a WAV file of 32-bit floating point

}  // namespace

TEST_CASE("responses without samples are refused") {
    const TemporaryFolder folder;
    const fs::path out = small_dataset(folder);
    forge_shard(out / "shard-00000.tar",
                [](std::size_t, std::string&, std::string& wav) { wav.resize(kHeader); });
    require_no_merge(out, "shard-00000.tar: item 0: a response of 58 bytes; expected 2 channels");
}

TEST_CASE("a geometry without a room, or of another type, is refused") {
    const TemporaryFolder folder;
    const fs::path out = small_dataset(folder);
    for (const std::string geometry : {"{}", "[]", "\"box\"", "{\"box\": []}", "null"}) {
        forge_shard(out / "shard-00000.tar", [&](std::size_t, std::string& json, std::string&) {
            const std::size_t at = json.find("\"geometry\": ") + 12;
            json.replace(at, json.find(", \"materials\"") - at, geometry);
        });
        require_no_merge(out,
                         "shard-00000.tar: item 0: /geometry: is not that of the plan; expected");
    }
}

TEST_CASE("fewer rows of T30 than microphones are refused") {
    const TemporaryFolder folder;
    const fs::path out = small_dataset(folder);
    forge_shard(out / "shard-00000.tar", [](std::size_t item, std::string& json, std::string&) {
        if (item == 0) return;
        const std::size_t at = json.find("\"T30\": [[") + 8;
        json.erase(at, json.find("], [", at) + 3 - at);
    });
    require_no_merge(out, "shard-00000.tar: item 1: /T30: 1 microphones; expected 2");
}

TEST_CASE("a hash with line breaks forges no row of the index") {
    const TemporaryFolder folder;
    const fs::path out = small_dataset(folder);
    forge_shard(out / "shard-00000.tar", [](std::size_t, std::string& json, std::string&) {
        const std::size_t at = json.find("\"scene_sha256\": \"") + 17;
        json.replace(at, 64, "x\\u000a7,evil,=cmd|'/C calc'!A0");
    });
    require_no_merge(out, "shard-00000.tar: item 0: /scene_sha256: expected 64 hexadecimal digits");
}

TEST_CASE("another number of channels than the plan's is refused") {
    const TemporaryFolder folder;
    const fs::path out = small_dataset(folder);
    forge_shard(out / "shard-00000.tar", [](std::size_t, std::string&, std::string& wav) {
        wav[22] = 4;  // channels; those of the plan are 2
    });
    require_no_merge(out, "shard-00000.tar: item 0: /samples: the response is not a WAV file of 2");
}

TEST_CASE("a plan with more items than scenes can have is refused by its name") {
    const TemporaryFolder folder;
    const fs::path out = small_dataset(folder);
    std::string plan = read_file(out / "plan.json");
    replace_part(plan, "\"items\": 2", "\"items\": 18446744073709551615");
    folder.write("out/plan.json", plan);
    for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
             {"run", out, "--shard", "0"}, {"status", out}, {"merge", out, "--to", "wav"}})
        require_refused(run_dataset(arguments),
                        "plan.json: /items: 18446744073709551615 is out of range; expected 1 to");
}

TEST_CASE("a pipe as the scene of a manifest is refused and blocks nothing") {
    const TemporaryFolder folder;
    REQUIRE(mkfifo((folder.path() / "pipe").c_str(), 0600) == 0);
    std::string manifest = box_manifest(1);
    replace_part(manifest, "\"rooms\": [", R"("rooms": [{"count": 1, "scene": "pipe"}, )");
    require_refused(run_dataset({"plan", folder.write("manifest.json", manifest), "--out",
                                 folder.path() / "out", "--shards", "1"}),
                    "pipe: is not a regular file; expected a scene file");
}
