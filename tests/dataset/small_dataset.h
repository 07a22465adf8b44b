#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/program.h"

namespace aula::test {

/// A manifest of `scenes` small boxes, with one source, two receivers and short, noisy responses.
std::string box_manifest(int scenes, const std::string& more = {});

/// Runs `aula dataset` with further arguments.
ProgramResult run_dataset(const std::vector<std::string>& arguments);

/// Runs it and requires success.
ProgramResult require_dataset(const std::vector<std::string>& arguments);

/// Computes the shards 0 to `shards` - 1 of a dataset.
void run_shards(const std::filesystem::path& folder, int shards,
                const std::vector<std::string>& options = {});

/// Plans a manifest into a new folder and computes all its shards.
std::filesystem::path make_dataset(const TemporaryFolder& folder, const std::string& manifest,
                                   const std::string& name, int shards);

/// SHA256SUMS of a dataset after it is merged.
std::string merged_sums(const std::filesystem::path& folder, const std::string& format);

/// Names of the shards and of their unfinished files in a folder.
std::vector<std::string> shard_names(const std::filesystem::path& folder);

}  // namespace aula::test
