#pragma once

#include <filesystem>
#include <string>

#include "apps/dataset/plan/plan.h"

namespace aula {

/// What the jobs of a dataset ask of Slurm.
struct SlurmOptions {
    int cpus = 1;                   ///< of a task, which computes one shard with as many threads
    std::string time = "04:00:00";  ///< limit of a task
    int limit = 100;                ///< tasks of an array that run at the same time
};

/// Writes two scripts to the dataset's folder. slurm-array.sh computes one shard in each task.
/// slurm-sweep.sh submits arrays of the missing shards and then itself, to run after them, until
/// none is missing. Returns the latter's path. Throws InputError, Failure.
std::filesystem::path write_slurm_scripts(const Plan& plan, const SlurmOptions& options);

}  // namespace aula
