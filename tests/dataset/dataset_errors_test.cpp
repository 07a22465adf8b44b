#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>

#include "apps/output/folder_lock.h"
#include "tests/dataset/small_dataset.h"

namespace {

using namespace aula;
using namespace aula::test;

/// Requires exit status 2 and one line that contains `message`.
void require_refused(const ProgramResult& result, const std::string& message) {
    INFO(result.err);
    CHECK(result.status == 2);
    CHECK(result.out.empty());
    CHECK(result.err.starts_with("aula: "));
    CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
    CHECK(result.err.find(message) != std::string::npos);
}

}  // namespace

TEST_CASE("a bad manifest is one line with its place, exit status 2 and no folder") {
    struct Bad {
        const char* part;     ///< of the manifest
        const char* instead;  ///< what replaces it
        const char* message;
    };
    // clang-format off
    const Bad bad[] = {
        {"{\"aula", "[\"aula", "line 1"},
        {"\"aula_dataset\": 1", "\"aula_dataset\": 2", "/aula_dataset: "},
        {"\"licence\": \"CC0-1.0\", ", "", "licence"},
        {"\"CC0-1.0\"", "\"two\\nlines\"", "/licence: "},
        {"\"seed\": 5", "\"seed\": -1", "/seed: "},
        {"\"seed\": 5", "\"sead\": 5", "sead"},
        {"\"count\": 3", "\"count\": 0", "/rooms/0/count: "},
        {"\"count\": 3", "\"count\": 1e12", "/rooms/0/count: "},
        {"\"count\": 3,", "", "count"},
        {"[3, 6]", "[6, 3]", "/rooms/0/box/size_m/0/uniform: the numbers descend"},
        {"[3, 6]", "[3]", "/rooms/0/box/size_m/0/uniform: "},
        {"[3, 6]", "[3, 1e9]", "/rooms/0/box/size_m/0/uniform/1: "},
        {"[3, 6]", "\"3\"", "/rooms/0/box/size_m/0/uniform: "},
        {"{\"uniform\": [3, 6]}", "{\"gaussian\": [3, 6]}", "gaussian"},
        {"{\"uniform\": [3, 6]}", "{\"choice\": []}", "/rooms/0/box/size_m/0/choice: is empty"},
        {"{\"uniform\": [3, 6]}", "{}", "/rooms/0/box/size_m/0: "},
        {", 2.5]", "]", "/rooms/0/box/size_m: "},
        {"\"carpet\"", "\"carpett\"", "there is no material"},
        {"[0.3, 0.6]", "[0.3, 1.6]", "/uniform/1: "},
        {"{\"uniform\": [0.3, 0.6]}", "[0.1, 0.2]", "/absorption: "},
        {"\"box\"", "\"sphere\"", "sphere"},
        {"\"box\": {", "\"scene\": \"room.json\", \"box\": {", "/rooms/0: "},
        {"\"count\": 2", "\"count\": 2.5", "/receivers/count: "},
        {"\"count\": 2", "\"count\": {\"uniform\": [1, 2.5]}", "/receivers/count/uniform/1: "},
        {"\"count\": 2,", "\"count\": 10001,", "/receivers/count: "},
        {"\"seed\": 5", "\"sources\": {\"count\": {\"uniform\": [1, 10000]}}, \"array\": "
         "[[0,0,0],[0,0,1],[0,0,2],[0,0,3],[0,0,4],[0,0,5]]", "up to 120000 pairs"},
        {"[-180, 180]", "[-180, 1e4]", "/receivers/yaw_deg/uniform/1: "},
        {"\"rays\": 50", "\"rays\": 0", "/simulation/rays: "},
        {"\"rays\": 50", "\"seed\": 1", "/simulation/seed: "},
        {"\"rays\": 50", "\"threads\": 2", "/simulation/threads: "},
        {"\"rays\": 50", "\"rais\": 50", "rais"},
        {"\"frames\": 1", "\"frames\": 1, \"t30\": 0.1", "/measurement/frames: "},
        {"\"frames\": 1", "\"t30\": 0", "/measurement/t30: "},
        {"\"sample_rate_hz\": 8000", "\"sample_rate_hz\": 8000.5", "/output/sample_rate_hz: "},
        {"\"sample_rate_hz\": 8000", "\"sample_rate_hz\": 100", "/output/sample_rate_hz: "},
        {"\"sample_rate_hz\": 8000", "\"format\": \"stereo\"", "/output/format: unknown format"},
        {"\"seed\": 5", "\"array\": []", "/array: "},
        {"\"seed\": 5", "\"array\": [[0, 0]]", "/array/0: "},
        {"\"seed\": 5", "\"date\": \"today\"", "/date: "},
        {"\"seed\": 5", "\"date\": \"2026-02-30\"", "/date: "},
        {"\"seed\": 5", "\"sources\": {\"directivity\": \"trombone\"}", "/sources/directivity: "},
        {"\"seed\": 5", "\"seed\": 5, \"seed\": 6", "seed"},
        {"\"rooms\": [{", "\"rooms\": [{\"count\": 1, \"scene\": \"none.json\"}, {",
         "none.json: no such file"},
    };
    // clang-format on
    const TemporaryFolder folder;
    for (const Bad& b : bad) {
        std::string manifest = box_manifest(3);
        const std::size_t at = manifest.find(b.part);
        INFO(b.part << " -> " << b.instead);
        REQUIRE(at != std::string::npos);
        manifest.replace(at, std::string(b.part).size(), b.instead);
        const std::string file = folder.write("manifest.json", manifest);
        require_refused(
            run_dataset({"plan", file, "--out", folder.path() / "out", "--shards", "1"}),
            b.message);
        CHECK(names_in(folder.path()) == std::vector<std::string>{"manifest.json"});
    }
    for (const char* const file : {"/", "/dev/zero", "/nowhere/manifest.json"})
        require_refused(
            run_dataset({"plan", file, "--out", folder.path() / "out", "--shards", "1"}), file);
}

TEST_CASE("bad arguments of aula dataset are one line and exit status 2") {
    const TemporaryFolder folder;
    const std::string manifest = folder.write("manifest.json", box_manifest(3));
    const std::string out = folder.path() / "out";
    require_dataset({"plan", manifest, "--out", out, "--shards", "2"});
    struct Bad {
        std::vector<std::string> arguments;
        const char* message;
    };
    const Bad bad[] = {
        {{}, "expected plan, run, status, slurm or merge"},
        {{"plann"}, "\"plann\" is not known"},
        {{"plan"}, "no manifest given"},
        {{"plan", manifest, "--shards", "1"}, "--out is missing"},
        {{"plan", manifest, "--out", out}, "--shards is missing"},
        {{"plan", manifest, "--out", out, "--shards", "4"}, "expected at most one for each scene"},
        {{"plan", manifest, "--out", out, "--shards", "0"}, "--shards: \"0\" is not usable"},
        {{"plan", manifest, "--out", out, "--shards"}, "--shards: has no value"},
        {{"plan", manifest, "--out", manifest, "--shards", "1"}, "expected the name of a folder"},
        {{"plan", manifest, "more", "--out", out, "--shards", "1"}, "one argument too many"},
        {{"run", out}, "--shard is missing"},
        {{"run", out, "--shard", "2"}, "--shard: 2 is not a shard; expected 0 to 1"},
        {{"run", out, "--shard", "1", "--shard", "1"}, "--shard: is given more than once"},
        {{"run", out, "--shard", "1", "--threads", "0"}, "--threads: \"0\" is not usable"},
        {{"run", folder.path(), "--shard", "0"}, "expected the plan of aula dataset plan"},
        {{"status", out, "--shard", "1"}, "\"--shard\" is not known"},
        {{"slurm", out, "--time", "soon"}, "--time: \"soon\" is not usable"},
        {{"merge", out}, "--to is missing"},
        {{"merge", out, "--to", "flac"}, "expected hdf5, sofa or wav"},
        {{"merge", out, "--to", "wav"}, "has no usable shard 0-1; expected all shards"},
    };
    for (const Bad& b : bad) require_refused(run_dataset(b.arguments), b.message);
    CHECK(names_in(out) == std::vector<std::string>{"plan.json", "plan.jsonl"});
}

TEST_CASE("a damaged plan is one line and exit status 2") {
    const TemporaryFolder folder;
    const std::string manifest = folder.write("manifest.json", box_manifest(3));
    const std::filesystem::path out = folder.path() / "out";
    require_dataset({"plan", manifest, "--out", out, "--shards", "2"});
    const std::string plan = read_file(out / "plan.json");
    const std::string lines = read_file(out / "plan.jsonl");
    const auto refuse = [&](const char* name, const std::string& content) {
        folder.write(std::string("out/") + name, content);
        require_refused(run_dataset({"run", out, "--shard", "1"}), "plan.json");
        folder.write("out/plan.json", plan);
        folder.write("out/plan.jsonl", lines);
    };
    refuse("plan.json", "{}");
    refuse("plan.json", plan.substr(0, plan.size() / 2));
    refuse("plan.jsonl", "");
    refuse("plan.jsonl", lines.substr(0, lines.size() - 20));
    std::string other = lines;
    other.replace(other.find("\"version\": \""), 13, "\"version\": \"9");
    refuse("plan.jsonl", other);
    // A digit of a position, in a line of either shard.
    for (const std::size_t line : {lines.find("\"scene\": 0"), lines.find("\"scene\": 2")}) {
        std::string changed = lines;
        const std::size_t digit = changed.find("\"position\": [", line) + 15;
        changed[digit] = changed[digit] == '1' ? '2' : '1';
        folder.write("out/plan.jsonl", changed);
        const bool own = line == lines.find("\"scene\": 2");
        const ProgramResult run = run_dataset({"run", out, "--shard", "1"});
        CHECK(run.status == (own ? 2 : 0));
        for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
                 {"status", out}, {"status", out, "--missing"}, {"merge", out, "--to", "wav"}})
            require_refused(run_dataset(arguments), "plan.jsonl: is not what plan.json");
        std::filesystem::remove(out / "shard-00001.tar");
    }
    CHECK(names_in(out) == std::vector<std::string>{"plan.json", "plan.jsonl"});
}

TEST_CASE("one changed byte of a shard is found by a merge and by status --verify") {
    const TemporaryFolder folder;
    const std::filesystem::path out = make_dataset(folder, box_manifest(2), "out", 2);
    CHECK(require_dataset({"status", out, "--missing", "--verify"}).out.empty());
    const std::string shard = read_file(out / "shard-00001.tar");
    // A digit of the description of item 2, and a byte of the samples of item 3.
    for (const std::size_t at : {shard.find("\"seed\": ") + 10, shard.rfind("data") + 400}) {
        std::string changed = shard;
        changed[at] = static_cast<char>(changed[at] ^ 1);
        folder.write("out/shard-00001.tar", changed);
        CHECK(require_dataset({"status", out, "--missing"}).out.empty());
        CHECK(require_dataset({"status", out, "--missing", "--verify"}).out == "1\n");
        const std::string status = require_dataset({"status", out, "--verify"}).out;
        CHECK(status.find("1 of 2 shards complete\n2 of 4 items") == 0);
        CHECK(status.find("shard-00001.tar: item ") != std::string::npos);
        for (const char* const format : {"wav", "hdf5", "sofa"})
            require_refused(run_dataset({"merge", out, "--to", format}), "shard-00001.tar: item ");
    }
    CHECK(names_in(out) == std::vector<std::string>{"plan.json", "plan.jsonl", "shard-00000.tar",
                                                    "shard-00001.tar"});
}

TEST_CASE("a plan says how many scenes have no positions") {
    const TemporaryFolder folder;
    std::string manifest = box_manifest(3);
    manifest.replace(
        manifest.find("\"rooms\": ["), 10,
        R"("rooms": [{"count": 2, "box": {"size_m": [0.9, 3, 3], "walls": "wood"}}, )");
    const std::string file = folder.write("manifest.json", manifest);
    const std::vector<std::string> plan{"plan",     file, "--out", folder.path() / "out",
                                        "--shards", "1"};
    // Also when the plan is there.
    for (int i = 0; i < 2; ++i) {
        const ProgramResult result = run_dataset(plan);
        CHECK(result.status == 0);
        CHECK(result.out.find("10 items in 5 scenes and 1 shard") == 0);
        CHECK(result.err ==
              "aula: warning: 2 of 5 scenes have no positions with the clearances: "
              "no responses\n");
    }
}

TEST_CASE("a folder that cannot be written is one line and exit status 2") {
    const TemporaryFolder folder;
    const std::filesystem::path out = make_dataset(folder, box_manifest(1), "out", 1);
    const std::filesystem::path half = folder.path() / "half";
    require_dataset({"plan", folder.path() / "manifest.json", "--out", half, "--shards", "1"});
    std::filesystem::permissions(folder.path(), std::filesystem::perms(0755));
    for (const auto& closed : {out, half})
        std::filesystem::permissions(closed, std::filesystem::perms(0555));
    // Root may write everywhere.
    const std::vector<std::string> user{"setpriv", "--reuid=65534", "--clear-groups"};
    const auto refused = [&](std::vector<std::string> command) {
        command.insert(command.begin(), {AULA_PROGRAM, "dataset"});
        if (geteuid() == 0) command.insert(command.begin(), user.begin(), user.end());
        require_refused(run_program(command), "Permission denied");
    };
    for (const char* const format : {"wav", "hdf5", "sofa"})
        refused({"merge", out, "--to", format});
    refused({"run", half, "--shard", "0"});
    refused({"slurm", out});
    for (const auto& closed : {out, half})
        std::filesystem::permissions(closed, std::filesystem::perms(0755));
}

TEST_CASE("a pipe in the folder of a dataset is refused and blocks nothing") {
    const TemporaryFolder folder;
    const std::filesystem::path out = make_dataset(folder, box_manifest(2), "out", 2);
    std::filesystem::remove(out / "shard-00001.tar");
    REQUIRE(mkfifo((out / "shard-00001.tar").c_str(), 0600) == 0);
    CHECK(require_dataset({"status", out, "--missing"}).out == "1\n");
    require_refused(run_dataset({"merge", out, "--to", "wav"}), "has no usable shard 1");
    require_refused(run_dataset({"run", out, "--shard", "1"}),
                    "shard-00001.tar: is not a regular file");
    std::filesystem::remove(out / "shard-00001.tar");
    require_dataset({"run", out, "--shard", "1"});
    const std::string sums = merged_sums(out, "wav");
    std::filesystem::remove(out / "wav/SHA256SUMS");
    REQUIRE(mkfifo((out / "wav/SHA256SUMS").c_str(), 0600) == 0);
    require_refused(run_dataset({"merge", out, "--to", "wav"}), "which no merge has written");
    std::filesystem::remove(out / "plan.jsonl");
    REQUIRE(mkfifo((out / "plan.jsonl").c_str(), 0600) == 0);
    for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
             {"status", out}, {"run", out, "--shard", "0"}, {"merge", out, "--to", "hdf5"}})
        require_refused(run_dataset(arguments), "plan.jsonl: is not a regular file");
}

TEST_CASE("two processes do not write the same plan or merge") {
    const TemporaryFolder folder;
    const std::filesystem::path out = make_dataset(folder, box_manifest(1), "out", 1);
    const std::string sums = merged_sums(out, "hdf5");
    std::filesystem::create_directory(out / ".aula-hdf5.part");
    {
        const FolderLock merging(out / ".aula-hdf5.part");
        require_refused(run_dataset({"merge", out, "--to", "hdf5"}), "another process writes here");
        CHECK(std::filesystem::exists(out / ".aula-hdf5.part"));
        merged_sums(out, "wav");
    }
    // What a killed merge has left is no obstacle.
    CHECK(merged_sums(out, "hdf5") == sums);
    CHECK_FALSE(std::filesystem::exists(out / ".aula-hdf5.part"));
    const FolderLock planning(out);
    require_refused(
        run_dataset({"plan", folder.path() / "manifest.json", "--out", out, "--shards", "1"}),
        "another process writes here");
}

TEST_CASE("a merged folder keeps the permissions of the one that it replaces") {
    const TemporaryFolder folder;
    const std::filesystem::path out = make_dataset(folder, box_manifest(1), "out", 1);
    merged_sums(out, "wav");
    for (const unsigned mode : {02770U, 0700U, 0755U}) {
        std::filesystem::permissions(out / "wav", std::filesystem::perms(mode));
        merged_sums(out, "wav");
        CHECK(std::filesystem::status(out / "wav").permissions() == std::filesystem::perms(mode));
    }
}

TEST_CASE("a merge replaces an earlier merge only, and no file of others") {
    const TemporaryFolder folder;
    const std::filesystem::path out = make_dataset(folder, box_manifest(1), "out", 1);
    const std::string sums = merged_sums(out, "wav");
    CHECK(merged_sums(out, "wav") == sums);
    folder.write("out/wav/000/notes.txt", "mine");
    require_refused(run_dataset({"merge", out, "--to", "wav"}), "contains \"000/notes.txt\"");
    CHECK(read_file(out / "wav/000/notes.txt") == "mine");
    CHECK(read_file(out / "wav/SHA256SUMS") == sums);
    // Nor files that their owner has protected.
    std::filesystem::remove(out / "wav/000/notes.txt");
    for (const char* const name : {"wav/SHA256SUMS", "wav/000/000001.json", "wav/000", "wav"}) {
        CAPTURE(name);
        const auto mode = std::filesystem::status(out / name).permissions();
        const auto writable = std::filesystem::perms(0222);
        std::filesystem::permissions(out / name, mode & ~writable);
        require_refused(run_dataset({"merge", out, "--to", "wav"}),
                        (out / name).string() + ": is write-protected (mode ");
        std::filesystem::permissions(out / name, mode);
    }
    CHECK(read_file(out / "wav/SHA256SUMS") == sums);
    folder.write("out/hdf5", "mine");
    require_refused(run_dataset({"merge", out, "--to", "hdf5"}), "is not a folder");
    CHECK(read_file(out / "hdf5") == "mine");
    std::filesystem::create_directory_symlink(folder.path(), out / "sofa");
    require_refused(run_dataset({"merge", out, "--to", "sofa"}), "is not a folder");
    CHECK(std::filesystem::is_symlink(out / "sofa"));
}
