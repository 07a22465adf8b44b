#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <random>
#include <thread>

#include "tests/dataset/small_dataset.h"

namespace {

using namespace aula::test;
namespace fs = std::filesystem;

/// Of scenes that take about 0.1 s each.
std::string long_manifest(int scenes) {
    std::string manifest = box_manifest(scenes);
    manifest.replace(manifest.find("\"frames\": 1"), 11, "\"frames\": 15");
    return manifest;
}

fs::path plan(const TemporaryFolder& folder, const std::string& manifest, int shards) {
    const std::string file = folder.write("manifest.json", manifest);
    const fs::path out = folder.path() / "out";
    require_dataset({"plan", file, "--out", out, "--shards", std::to_string(shards)});
    return out;
}

std::vector<std::string> run_command(const fs::path& out, int shard) {
    return {AULA_PROGRAM, "dataset", "run", out, "--shard", std::to_string(shard)};
}

/// True when a shard is being written.
bool has_part(const fs::path& out) {
    const std::vector<std::string> names = shard_names(out);
    return std::any_of(names.begin(), names.end(),
                       [](const std::string& name) { return name.ends_with(".part"); });
}

void wait_for_part(Program& program, const fs::path& out) {
    while (program.running() && !has_part(out))
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

}  // namespace

// AULA_DATASET_KILLS tasks are killed, by default 2.
TEST_CASE("tasks that are killed at random are complete and equal after a sweep") {
    const char* const asked = std::getenv("AULA_DATASET_KILLS");
    const int kills = asked != nullptr ? std::atoi(asked) : 2;
    const int shards = 2;
    const TemporaryFolder undisturbed;
    const std::string expected =
        merged_sums(make_dataset(undisturbed, long_manifest(5), "out", shards), "wav");
    const TemporaryFolder folder;
    const fs::path out = plan(folder, long_manifest(5), shards);
    std::minstd_rand random(3);
    std::uniform_int_distribution<int> pause_ms(0, 150);
    int killed = 0;
    for (int round = 0; killed < kills; ++round) {
        const int shard = round % shards;
        Program program(run_command(out, shard));
        wait_for_part(program, out);
        std::this_thread::sleep_for(std::chrono::milliseconds(pause_ms(random)));
        program.signal(SIGKILL);
        const ProgramResult result = program.wait();
        if (result.by_signal) ++killed;
        // A shard that was faster than the signal is computed again.
        for (const std::string& name : shard_names(out))
            if (name.starts_with("shard-") && killed < kills) fs::remove(out / name);
    }
    const std::string missing = require_dataset({"status", out, "--missing"}).out;
    CHECK_FALSE(missing.empty());
    run_shards(out, shards);
    CHECK(require_dataset({"status", out, "--missing"}).out.empty());
    CHECK(merged_sums(out, "wav") == expected);
}

TEST_CASE("SIGTERM removes the unfinished shard, and the exit status is 143") {
    const TemporaryFolder folder;
    const fs::path out = plan(folder, long_manifest(200), 1);
    for (const char* const threads : {"1", "3"}) {
        std::vector<std::string> command = run_command(out, 0);
        command.insert(command.end(), {"--threads", threads});
        Program program(command);
        wait_for_part(program, out);
        program.signal(SIGTERM);
        const ProgramResult result = program.wait();
        CHECK(result.status == 143);
        CHECK_FALSE(result.by_signal);
        CHECK(result.err.empty());
        CHECK(shard_names(out).empty());
    }
}

TEST_CASE("a full disk leaves no half shard, and the program says so") {
    const TemporaryFolder folder;
    const fs::path out = plan(folder, box_manifest(4), 1);
    // A limit of 16 blocks of 1024 bytes on the size of files.
    std::string command = "ulimit -f 16; exec";
    for (const std::string& word : run_command(out, 0)) command += " '" + word + "'";
    const ProgramResult result = run_program({"bash", "-c", command});
    CHECK(result.status == 1);
    CHECK(result.err.find("shard-00000.tar: cannot write: ") != std::string::npos);
    CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
    CHECK(shard_names(out).empty());

    run_shards(out, 1);
    const auto fails = [](const fs::path& dataset, const std::string& format, int limit) {
        const ProgramResult merged = run_program({"bash", "-c",
                                                  "ulimit -f " + std::to_string(limit) +
                                                      "; exec '" AULA_PROGRAM "' dataset merge '" +
                                                      dataset.string() + "' --to " + format});
        INFO(format << ", " << limit << ": " << merged.err);
        CHECK(merged.status == 1);
        CHECK(merged.err.find("cannot write") != std::string::npos);
        CHECK(merged.err.find("File too large") != std::string::npos);
        CHECK(merged.err.find(".aula-") == std::string::npos);
        CHECK(names_in(dataset) ==
              std::vector<std::string>{"plan.json", "plan.jsonl", "shard-00000.tar"});
    };
    for (const char* const format : {"wav", "hdf5", "sofa"}) fails(out, format, 1);
    // More than HDF5 buffers: the disk is full before the file is closed.
    const TemporaryFolder other;
    const fs::path large =
        make_dataset(other, box_manifest(12, R"("output": {"sample_rate_hz": 192000})"), "out", 1);
    for (const int limit : {1, 256}) fails(large, "hdf5", limit);
}
