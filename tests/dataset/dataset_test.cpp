#include <sys/resource.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "aula/audio/sound_file.h"
#include "tests/dataset/small_dataset.h"

namespace {

using namespace aula::test;
using nlohmann::json;
namespace fs = std::filesystem;

std::vector<json> lines_of(const fs::path& file) {
    std::istringstream text(read_file(file));
    std::vector<json> lines;
    for (std::string line; std::getline(text, line);) lines.push_back(json::parse(line));
    return lines;
}

#ifndef __SANITIZE_ADDRESS__
/// Largest memory of a child process so far, in kilobytes.
long children_kb() {
    rusage usage{};
    getrusage(RUSAGE_CHILDREN, &usage);
    return usage.ru_maxrss;
}
#endif

json item_of(const fs::path& merged, const std::string& name) {
    return json::parse(read_file(merged / "000" / (name + ".json")));
}

}  // namespace

TEST_CASE("a plan depends on the manifest only, and its scenes not on the number of shards") {
    const TemporaryFolder folder;
    const std::string manifest = folder.write("m.json", box_manifest(40));
    const auto plan = [&](const std::string& name, const std::string& shards) {
        require_dataset({"plan", manifest, "--out", folder.path() / name, "--shards", shards});
        return folder.path() / name;
    };
    const fs::path one = plan("a", "1");
    const fs::path seven = plan("b", "7");
    CHECK(read_file(one / "plan.jsonl") == read_file(seven / "plan.jsonl"));
    const std::string before = read_file(seven / "plan.json");
    plan("b", "7");
    CHECK(read_file(seven / "plan.json") == before);

    // The first scenes and their seeds are those of a longer plan.
    folder.write("m.json", box_manifest(50));
    const std::vector<json> longer = lines_of(plan("c", "1") / "plan.jsonl");
    const std::vector<json> shorter = lines_of(one / "plan.jsonl");
    REQUIRE(shorter.size() == 41);
    std::set<std::uint64_t> seeds;
    for (std::size_t i = 1; i < shorter.size(); ++i) {
        CHECK(shorter[i] == longer[i]);
        seeds.insert(shorter[i]["seed"].get<std::uint64_t>());
    }
    CHECK(seeds.size() == 40);
}

TEST_CASE("items have their description and response, in any number of shards and threads") {
    const TemporaryFolder folder;
    const fs::path one = make_dataset(folder, box_manifest(9), "one", 1);
    const fs::path seven = make_dataset(folder, box_manifest(9), "seven", 7);
    for (const char* const format : {"wav", "hdf5", "sofa"})
        CHECK(merged_sums(one, format) == merged_sums(seven, format));

    // The same bytes by two threads, in place of the shard of one.
    const std::string serial = read_file(one / "shard-00000.tar");
    fs::remove(one / "shard-00000.tar");
    run_shards(one, 1, {"--threads", "2"});
    CHECK(read_file(one / "shard-00000.tar") == serial);

    const json item = item_of(one / "wav", "000017");
    CHECK(item["item"] == 17);
    CHECK(item["scene"] == 8);
    CHECK(item["channels"] == 1);
    CHECK(item["T30"].size() == 1);
    CHECK(item["T30"][0].size() == 8);
    CHECK_FALSE(item.contains("error"));
    const auto sound = aula::sound_info(one / "wav/000/000017.wav");
    CHECK(sound.sample_rate_hz == 8000);
    CHECK(sound.channels == 1);
    CHECK(sound.samples == item["samples"].get<std::int64_t>());
    const auto samples = aula::read_sound(one / "wav/000/000017.wav", 8000).samples;
    const auto largest = *std::max_element(samples.begin(), samples.end());
    CHECK(largest > 0.01F);
    // index.csv has a line for each response, and nothing tells of the shards.
    const std::string index = read_file(one / "wav/index.csv");
    CHECK(std::count(index.begin(), index.end(), '\n') == 19);
    CHECK(read_file(one / "wav/README.md").find("CC0-1.0") != std::string::npos);
}

TEST_CASE("the steps of walks are items, source by source") {
    const TemporaryFolder folder;
    std::string manifest = box_manifest(2);
    const std::string receivers = R"("receivers": {"count": 2, )";
    manifest.replace(manifest.find(receivers), receivers.size(),
                     R"("sources": {"walk": {"steps": 2, "length_m": 0.5}},
                        "receivers": {"count": 2, "walk": {"steps": 3, "length_m": 0.4}, )");
    const fs::path walks = make_dataset(folder, manifest, "walks", 2);
    require_dataset({"merge", walks, "--to", "wav"});
    const json first = item_of(walks / "wav", "000012");
    CHECK(first["scene"] == 1);
    CHECK(first["source"]["name"] == "source-0-step-0");
    CHECK(item_of(walks / "wav", "000018")["source"]["name"] == "source-0-step-1");
    const auto x_of = [&](const char* name, std::size_t axis) {
        return item_of(walks / "wav", name)["receiver"]["position"][axis].get<double>();
    };
    for (std::size_t axis = 0; axis < 3; ++axis)
        CHECK(x_of("000013", axis) ==
              Approx((x_of("000012", axis) + x_of("000014", axis)) / 2).margin(2e-4));
    CHECK(std::hypot(x_of("000014", 0) - x_of("000012", 0),
                     x_of("000014", 1) - x_of("000012", 1)) == Approx(0.4).margin(2e-4));
    const auto wrong = folder.write("wrong.json", box_manifest(1, R"("array": [[0, 0, 0]],
        "sources": {"walk": {"steps": 1, "length_m": 1}})"));
    const auto result =
        run_dataset({"plan", wrong, "--out", folder.path() / "wrong", "--shards", "1"});
    CHECK(result.status == 2);
    CHECK(result.err.find("/sources/walk/steps") != std::string::npos);
}

TEST_CASE("an array has a channel for each microphone, a format its channels") {
    const TemporaryFolder folder;
    const fs::path array = make_dataset(
        folder, box_manifest(1, R"("array": [[0, 0.1, 0], [0, -0.1, 0], [0.1, 0, 0]])"), "a", 1);
    require_dataset({"merge", array, "--to", "wav"});
    const json item = item_of(array / "wav", "000001");
    CHECK(item["channels"] == 3);
    CHECK(item["T30"].size() == 3);
    REQUIRE(item["microphones"].size() == 3);
    // 0.2 m apart, whatever the yaw of the receiver; positions have 0.1 mm.
    double squared = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double difference =
            item["microphones"][0][axis].get<double>() - item["microphones"][1][axis].get<double>();
        squared += difference * difference;
    }
    CHECK(std::sqrt(squared) == Approx(0.2).margin(1e-4));

    const fs::path foa =
        make_dataset(folder, box_manifest(1, R"("output": {"format": "foa"})"), "foa", 1);
    require_dataset({"merge", foa, "--to", "wav"});
    CHECK(aula::sound_info(foa / "wav/000/000000.wav").channels == 4);
    CHECK(aula::sound_info(foa / "wav/000/000000.wav").sample_rate_hz == 48000);
}

TEST_CASE("a complete shard is kept, a damaged one is computed again") {
    const TemporaryFolder folder;
    const fs::path out = make_dataset(folder, box_manifest(2), "out", 2);
    const fs::path shard = out / "shard-00001.tar";
    const std::string bytes = read_file(shard);
    const auto time = fs::last_write_time(shard);
    CHECK(require_dataset({"run", out, "--shard", "1"}).out.empty());
    CHECK(fs::last_write_time(shard) == time);
    CHECK(require_dataset({"status", out, "--missing"}).out.empty());

    fs::resize_file(shard, bytes.size() / 2);
    CHECK(require_dataset({"status", out, "--missing"}).out == "1\n");
    const ProgramResult merged = run_dataset({"merge", out, "--to", "wav"});
    CHECK(merged.status == 2);
    CHECK(merged.err.find("has no usable shard 1; expected all shards") != std::string::npos);
    CHECK_FALSE(fs::exists(out / "wav"));
    run_shards(out, 2);
    CHECK(read_file(shard) == bytes);

    // A shard of another plan does not count, and another plan does not replace this one.
    const fs::path other = make_dataset(folder, box_manifest(3), "other", 1);
    fs::copy_file(other / "shard-00000.tar", out / "shard-00000.tar",
                  fs::copy_options::overwrite_existing);
    CHECK(require_dataset({"status", out, "--missing"}).out == "0\n");
    const ProgramResult replaced =
        run_dataset({"plan", folder.path() / "manifest.json", "--out", out, "--shards", "1"});
    CHECK(replaced.status == 2);
    CHECK(replaced.err.find("has shards of another plan") != std::string::npos);
    CHECK(names_in(out) == std::vector<std::string>{"plan.json", "plan.jsonl", "shard-00000.tar",
                                                    "shard-00001.tar"});
}

TEST_CASE("an item without a response is an error in its shard, which goes on") {
    const TemporaryFolder folder;
    fs::copy_file(fs::path(AULA_SOURCE_DIR) / "scenes/reference/cube_center.json",
                  folder.path() / "cube.json");
    // The second group has no place for a source 2 m off all walls.
    std::string manifest = box_manifest(1);
    manifest.replace(manifest.find("\"rooms\": ["), 10,
                     R"("sources": {"wall_clearance_m": 1}, "rooms": [
                        {"count": 1, "scene": "cube.json"},
                        {"count": 1, "box": {"size_m": [1.5, 3, 3], "walls": "wood"}}, )");
    const std::string file = folder.write("manifest.json", manifest);
    const fs::path out = folder.path() / "out";
    CHECK(run_dataset({"plan", file, "--out", out, "--shards", "1"}).err ==
          "aula: warning: 1 of 3 scenes has no positions with the clearances: no responses\n");
    fs::remove(folder.path() / "cube.json");
    run_shards(out, 1);
    const std::string status = require_dataset({"status", out}).out;
    CHECK(status.find("1 of 1 shard complete\n2 of 6 items with a response, 4 errors\nitem 0: ") ==
          0);
    CHECK(status.find("cube.json: no such file") != std::string::npos);
    CHECK(status.find("\nitem 2: no position has these clearances\n") != std::string::npos);
    require_dataset({"merge", out, "--to", "sofa"});
    CHECK(names_in(out / "sofa") == std::vector<std::string>{"README.md", "SHA256SUMS",
                                                             "errors.csv", "index.csv",
                                                             "scene-000002.sofa"});
    CHECK(read_file(out / "sofa/errors.csv").find("3,\"no position has these clearances\"\n") !=
          std::string::npos);
}

TEST_CASE("scenes of files have sources and receivers in their room, and other materials") {
    const TemporaryFolder folder;
    const std::string scene = fs::path(AULA_SOURCE_DIR) / "scenes/two_rooms.json";
    std::string manifest = box_manifest(1);
    const std::size_t rooms = manifest.find("\"rooms\"");
    manifest.replace(rooms, manifest.find("\"receivers\"") - rooms,
                     R"("rooms": [{"count": 2, "scene": ")" + scene +
                         R"(", "region_m": [[0, 0, 0.5], [20, 20, 2]],
                         "materials": {"rough brick": {"absorption": 0.25}}}], )");
    const fs::path out = make_dataset(folder, manifest, "out", 1);
    CHECK(require_dataset({"status", out}).out ==
          "1 of 1 shard complete\n4 of 4 items with a response, 0 errors\n");
    require_dataset({"merge", out, "--to", "wav"});
    const json item = item_of(out / "wav", "000000");
    CHECK(item["materials"]["rough brick"]["absorption"][3] == 0.25);
    CHECK(item["receiver"]["position"][2] > 0.5);
}

// The address sanitizer keeps freed memory.
#ifndef __SANITIZE_ADDRESS__
// AULA_DATASET_RESPONSES responses, by default 100.
TEST_CASE("the memory of a task does not grow with the number of responses") {
    const char* const asked = std::getenv("AULA_DATASET_RESPONSES");
    const int scenes = (asked != nullptr ? std::atoi(asked) : 100) / 20;
    const auto run = [](int count) {
        std::string manifest = box_manifest(count);
        manifest.replace(manifest.find("\"count\": 2"), 10, "\"count\": 20");
        const TemporaryFolder folder;
        const fs::path out = folder.path() / "out";
        require_dataset({"plan", folder.write("m.json", manifest), "--out", out, "--shards", "1"});
        const std::string printed = require_dataset({"run", out, "--shard", "0"}).out;
        WARN(printed);
        return children_kb();
    };
    const long few_kb = run(1);
    // Rooms and the grids of their modes differ in size, and the allocator keeps up to three arenas
    // of 8 MB.
    CHECK(run(scenes) < few_kb + 24000);
}
#endif
