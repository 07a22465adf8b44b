#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/dataset/merge/merge.h"
#include "apps/dataset/shards/slurm.h"

namespace aula {

/// The command line of `aula dataset`.
struct DatasetArguments {
    enum class Command { plan, run, status, slurm, merge };

    Command command = Command::plan;
    std::filesystem::path manifest;  ///< of `plan`
    std::filesystem::path folder;    ///< of the dataset
    std::size_t shards = 1;          ///< of `plan`
    std::size_t shard = 0;           ///< of `run`
    int threads = 1;                 ///< of `run`
    bool missing = false;            ///< of `status`
    bool verify = false;             ///< of `status`
    SlurmOptions slurm;
    MergeFormat format = MergeFormat::wav;
    bool quiet = false;
};

/// Parses what follows `aula dataset`. Throws InputError: one line.
DatasetArguments read_dataset_arguments(const std::vector<std::string>& words);

}  // namespace aula
