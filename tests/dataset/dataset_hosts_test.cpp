#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdlib>

#include "tests/dataset/small_dataset.h"

namespace {

using namespace aula::test;
namespace fs = std::filesystem;

/// Whether a program exists; otherwise the test says that it is skipped.
bool has_program(const std::string& name) {
    const bool found = are_installed(name);
    if (!found) WARN("skipped: " << name << " is missing (packages-test.txt)");
    return found;
}

/// Runs a script of Python; false if a module is missing.
bool run_python(const std::string& script) {
    const ProgramResult result = run_program({"/usr/bin/python3", "-c", script});
    if (result.err.find("ModuleNotFoundError") != std::string::npos) {
        WARN("skipped: h5py is missing (packages-test.txt)");
        return false;
    }
    INFO(result.err);
    CHECK(result.status == 0);
    return true;
}

/// A manifest of scenes that take about half a second each.
std::string slow_manifest(int scenes) {
    std::string manifest = box_manifest(scenes);
    manifest.replace(manifest.find("\"frames\": 1"), 11, "\"frames\": 60");
    manifest.replace(manifest.find("\"rays\": 50"), 10, "\"rays\": 200");
    return manifest;
}

fs::path plan_of(const TemporaryFolder& folder, const std::string& name, int shards) {
    const fs::path out = folder.path() / name;
    require_dataset({"plan", folder.path() / "manifest.json", "--out", out, "--shards",
                     std::to_string(shards)});
    return out;
}

}  // namespace

TEST_CASE("tar lists the members of a shard in their order") {
    const TemporaryFolder folder;
    const fs::path out = make_dataset(folder, box_manifest(1), "out", 1);
    const std::string shard = out / "shard-00000.tar";
    const ProgramResult listed = run_program({"tar", "tf", shard});
    CHECK(listed.err.empty());
    CHECK(listed.out == "000000.json\n000000.wav\n000001.json\n000001.wav\n");
    require_dataset({"merge", out, "--to", "wav"});
    const ProgramResult compared =
        run_program({"tar", "-C", out / "wav/000", "-df", shard, "000000.wav", "000001.json"});
    // Only the times differ.
    CHECK(compared.out.find("Contents") == std::string::npos);
    const ProgramResult sums =
        run_program({"sh", "-c", "cd '" + (out / "wav").string() + "' && sha256sum -c SHA256SUMS"});
    CHECK(sums.status == 0);
}

TEST_CASE("h5py reads a merged HDF5 file with the samples of the WAV files") {
    const TemporaryFolder folder;
    const fs::path out =
        make_dataset(folder, box_manifest(2, R"("array": [[0, 0.1, 0], [0, -0.1, 0]])"), "out", 2);
    for (const char* const format : {"wav", "hdf5", "sofa"})
        require_dataset({"merge", out, "--to", format});
    run_python(R"(
import json, h5py, numpy as np
out = ')" + out.string() +
               R"('
with h5py.File(out + '/hdf5/responses.h5') as f:
    assert f['response'].shape[:2] == (4, 2) and f['response'].dtype == np.float32
    assert f.attrs['licence'] == b'CC0-1.0', f.attrs['licence']
    assert list(f['item']) == [0, 1, 2, 3] and list(f['scene']) == [0, 0, 1, 1]
    for row in range(4):
        wav = open(f'{out}/wav/000/{row:06}.wav', 'rb').read()
        x = np.frombuffer(wav[58:], '<f4').reshape(-1, 2).T
        assert np.array_equal(f['response'][row, :, :f['samples'][row]], x) and np.abs(x).max() > 0
        item = json.loads(f['description'][row])
        assert item['item'] == row
        assert np.allclose(f['source_position'][row], item['source']['position'], atol=1e-4)
        t30 = np.array(item['T30'], float)
        assert np.allclose(f['T30'][row], t30, equal_nan=True)
    first = f['response'][2:4]
with h5py.File(out + '/sofa/scene-000001.sofa') as f:
    ir = f['Data.IR']
    assert ir.shape[:2] == (2, 2) and np.array_equal(ir[:], first[:, :, :ir.shape[2]])
    assert f['Data.SamplingRate'][0] == 48000
    assert np.allclose(np.linalg.norm(f['ListenerView'], axis=1), 1)
    assert np.allclose(f['ReceiverPosition'][:, :, 0], [[0, .1, 0], [0, -.1, 0]])
    assert ir.dims[0][0].name == '/M'
)");
}

TEST_CASE("ncdump reads a merged SOFA file as SingleRoomSRIR") {
    if (!has_program("ncdump")) return;
    const TemporaryFolder folder;
    const fs::path out = make_dataset(folder, box_manifest(1), "out", 1);
    require_dataset({"merge", out, "--to", "sofa"});
    const ProgramResult dump = run_program(
        {"ncdump", "-v", "Data.SamplingRate,RoomCornerB", out / "sofa/scene-000000.sofa"});
    CHECK(dump.err.empty());
    CHECK(dump.status == 0);
    for (const char* const text :
         {"M = 2 ;", "R = 1 ;", "C = 3 ;", "Data.IR(M, R, N)", "ReceiverPosition(R, C, I)",
          "SourcePosition:Units = \"metre\"", ":SOFAConventions = \"SingleRoomSRIR\"",
          ":DataType = \"FIR\"", ":RoomType = \"shoebox\"", ":License = \"CC0-1.0\"",
          "Data.SamplingRate = 8000 ;"}) {
        INFO(text);
        CHECK(dump.out.find(text) != std::string::npos);
    }
}

TEST_CASE("GNU parallel gives the merged bytes of one shard") {
    if (!has_program("parallel")) return;
    const TemporaryFolder folder;
    const fs::path one = make_dataset(folder, box_manifest(6), "one", 1);
    const fs::path out = plan_of(folder, "out", 5);
    const ProgramResult result =
        run_program({"sh", "-c",
                     "seq 0 4 | parallel -q -j 2 '" AULA_PROGRAM "' dataset run '" + out.string() +
                         "' --shard {}"});
    INFO(result.err);
    CHECK(result.status == 0);
    CHECK(merged_sums(out, "wav") == merged_sums(one, "wav"));
}

TEST_CASE("the sweep submits missing shards in arrays of a thousand, until none is missing") {
    const TemporaryFolder folder;
    folder.write("manifest.json", box_manifest(2100));
    const fs::path out = plan_of(folder, "it's out", 2100);
    require_dataset({"slurm", out, "--limit", "7", "--cpus", "2"});
    run_shards(out, 2);
    folder.write("it's out/.aula-0123.part", "");
    // In place of Slurm's: the arguments of each submission on a line.
    const fs::path sbatch = folder.write("sbatch", R"(#!/bin/bash
echo "$*" | sed 's/[0-9a-f]\{64\}  -$/HASH/' >> ')" + (folder.path() / "log").string() +
                                                       R"('
echo "1$(wc -l < ')" + (folder.path() / "log").string() +
                                                       R"(');cluster"
)");
    fs::permissions(sbatch, fs::perms::owner_all);
    const fs::path squeue =
        folder.write("squeue", "#!/bin/bash\ncat '" + (folder.path() / "queue").string() + "'\n");
    fs::permissions(squeue, fs::perms::owner_all);
    folder.write("queue", "");
    const std::string sweep = "PATH='" + folder.path().string() + "':$PATH bash '" +
                              folder.path().string() + "/it'\\''s out/slurm-sweep.sh' ";
    const auto submitted = [&](const std::string& arguments) {
        fs::remove(folder.path() / "log");
        const ProgramResult result = run_program({"bash", "-c", sweep + arguments});
        INFO(result.err);
        CHECK(result.status == 0);
        return read_file(folder.path() / "log");
    };
    const auto array = [](const std::string& indices, const std::string& first) {
        return "--parsable --array=" + indices +
               "%7 --output=slurm-logs/%A_%a.txt --export=ALL,AULA_FIRST_SHARD=" + first +
               " slurm-array.sh\n";
    };
    const std::string log = submitted("");
    for (const std::string& line :
         {array("2-999", "0"), array("0-999", "1000"), array("0-99", "2000"),
          std::string("--dependency=afterany:11:12:13 --output=slurm-logs/sweep-%j.txt "
                      "slurm-sweep.sh 0 HASH\n")}) {
        INFO(line << log);
        CHECK(log.find(line) != std::string::npos);
    }
    CHECK(shard_names(out) == std::vector<std::string>{"shard-00000.tar", "shard-00001.tar"});

    // Rounds without progress are counted, and end.
    const std::string hash = run_program({"bash", "-c", "printf 2-2099 | sha256sum"}).out;
    const std::string again = "2 '" + hash.substr(0, hash.size() - 1) + "'";
    CHECK(submitted("1 '" + hash.substr(0, hash.size() - 1) + "'").find("sweep.sh 2 HASH") !=
          std::string::npos);
    const ProgramResult ended = run_program({"bash", "-c", sweep + again});
    CHECK(ended.status == 1);
    CHECK(ended.err == "no shard was completed in 3 rounds, missing: 2-2099\n");

    // While a task or an earlier sweep is there, a sweep submits and removes nothing.
    const std::string script = read_file(out / "slurm-array.sh");
    const std::size_t name = script.find("--job-name=aula-dataset-") + 24;
    const std::string key = script.substr(name, script.find('\n', name) - name);
    CHECK(key.size() == 8);
    folder.write("it's out/.aula-0123.part", "");
    fs::remove(folder.path() / "log");
    const auto run_as = [&](const std::string& job, const std::string& queue) {
        folder.write("queue", queue);
        return run_program({"bash", "-c", "SLURM_JOB_ID=" + job + " " + sweep});
    };
    for (const auto& [job, queue] : {std::pair<std::string, std::string>{
                                         "30", "30 aula-sweep-" + key + "\n31 aula-dataset-" + key},
                                     {"30", "29 aula-sweep-" + key},
                                     {"", "31 aula-sweep-" + key}}) {
        INFO(queue);
        const ProgramResult result = run_as(job, queue);
        CHECK(result.status == 0);
        CHECK(result.out.find("works on this dataset; nothing is submitted") != std::string::npos);
        CHECK(fs::exists(out / ".aula-0123.part"));
        CHECK_FALSE(fs::exists(folder.path() / "log"));
    }
    // A later sweep gives way.
    run_as("30", "30 aula-sweep-" + key + "\n31 aula-sweep-" + key);
    CHECK_FALSE(fs::exists(out / ".aula-0123.part"));
    CHECK(read_file(folder.path() / "log").find("--dependency=afterany:30:11:12:13 ") !=
          std::string::npos);
}

// AULA_DATASET_KILLS tasks are killed, by default 2.
TEST_CASE("Slurm gives the merged bytes of one shard, with tasks that are killed and cancelled") {
    const char* const asked = std::getenv("AULA_DATASET_KILLS");
    const std::string kills = asked != nullptr ? asked : "2";
    const TemporaryFolder folder;
    folder.write("manifest.json", slow_manifest(2 * (4 + std::stoi(kills))));
    const std::string scripts = AULA_SOURCE_DIR "/tests/dataset/";
    const ProgramResult result =
        run_program({"bash", scripts + "slurm_one_node.sh", "bash", scripts + "slurm_test.sh",
                     AULA_PROGRAM, folder.path(), kills});
    if (result.status == 77) {
        WARN("skipped: " << result.out);
        return;
    }
    INFO(result.out << result.err);
    REQUIRE(result.status == 0);
    WARN(result.out);
    CHECK(result.out.starts_with("killed " + kills + " cancelled 1 "));
    CHECK(read_file(folder.path() / "second.txt").find("nothing is submitted") !=
          std::string::npos);
    const fs::path one = plan_of(folder, "one", 1);
    run_shards(one, 1);
    CHECK(merged_sums(folder.path() / "slurm", "wav") == merged_sums(one, "wav"));
}
