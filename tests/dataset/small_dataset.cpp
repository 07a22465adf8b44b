#include "tests/dataset/small_dataset.h"

#include <catch2/catch.hpp>

namespace aula::test {

std::string box_manifest(int scenes, const std::string& more) {
    return R"({"aula_dataset": 1, "licence": "CC0-1.0", "seed": 5,
        "rooms": [{"count": )" +
           std::to_string(scenes) + R"(, "box": {
            "size_m": [{"uniform": [3, 6]}, {"log_uniform": [3, 5]}, 2.5],
            "walls": {"choice": ["carpet", {"absorption": {"uniform": [0.3, 0.6]}}]}}}],
        "receivers": {"count": 2, "yaw_deg": {"uniform": [-180, 180]}},
        "simulation": {"rays": 50, "ir_length_s": 0.1, "specular_order": 1},
        "measurement": {"frames": 1}, )" +
           (more.empty() ? R"("output": {"sample_rate_hz": 8000})" : more) + "}";
}

ProgramResult run_dataset(const std::vector<std::string>& arguments) {
    std::vector<std::string> command{AULA_PROGRAM, "dataset"};
    command.insert(command.end(), arguments.begin(), arguments.end());
    return run_program(command);
}

ProgramResult require_dataset(const std::vector<std::string>& arguments) {
    ProgramResult result = run_dataset(arguments);
    INFO(arguments[0] << ": " << result.err);
    REQUIRE(result.status == 0);
    REQUIRE(result.err.empty());
    return result;
}

void run_shards(const std::filesystem::path& folder, int shards,
                const std::vector<std::string>& options) {
    for (int shard = 0; shard < shards; ++shard) {
        std::vector<std::string> arguments{"run", folder, "--shard", std::to_string(shard)};
        arguments.insert(arguments.end(), options.begin(), options.end());
        require_dataset(arguments);
    }
}

std::filesystem::path make_dataset(const TemporaryFolder& folder, const std::string& manifest,
                                   const std::string& name, int shards) {
    const std::string file = folder.write("manifest.json", manifest);
    const std::filesystem::path out = folder.path() / name;
    require_dataset({"plan", file, "--out", out, "--shards", std::to_string(shards)});
    run_shards(out, shards);
    return out;
}

std::string merged_sums(const std::filesystem::path& folder, const std::string& format) {
    require_dataset({"merge", folder, "--to", format});
    return read_file(folder / format / "SHA256SUMS");
}

std::vector<std::string> shard_names(const std::filesystem::path& folder) {
    std::vector<std::string> names;
    for (const std::string& name : names_in(folder))
        if (name.starts_with("shard-") || name.ends_with(".part")) names.push_back(name);
    return names;
}

}  // namespace aula::test
