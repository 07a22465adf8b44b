#include "apps/dataset/shards/slurm.h"

#include "apps/dataset/base/sha256.h"
#include "apps/output/output_file.h"

namespace aula {

namespace {

namespace fs = std::filesystem;

/// A text as one word of a shell.
std::string shell_word(const std::string& text) {
    std::string word = "'";
    for (const char c : text) word += c == '\'' ? "'\\''" : std::string(1, c);
    return word + "'";
}

void write_script(const fs::path& file, const std::string& text) {
    OutputFile out(file);
    out.write(text);
    out.commit();
    fs::permissions(file, fs::perms::owner_exec | fs::perms::group_exec, fs::perm_options::add);
}

std::string directives(const std::string& name, int cpus, const std::string& time) {
    return "#!/bin/bash\n#SBATCH --job-name=" + name +
           "\n#SBATCH --ntasks=1\n#SBATCH --cpus-per-task=" + std::to_string(cpus) +
           "\n#SBATCH --time=" + time + "\n#SBATCH --no-requeue\n";
}

constexpr const char* kTask =
    R"sh(shard=$((AULA_FIRST_SHARD + SLURM_ARRAY_TASK_ID))
exec "$aula" dataset run "$dataset" --shard $shard)sh";

// An index of an array is at most 1000, the default of Slurm's MaxArraySize less 1.
constexpr const char* kSweep = R"sh(
# Arguments, given by the sweep that submits this one: the number of sweeps in a row before which no
# shard was completed, and the checksum of the shards that were missing.
idle=${1:-0}
before=${2:-}

set -euo pipefail
cd "$dataset"
mkdir -p slurm-logs

# Only one sweep at a time: others end while a task is queued or runs, or an earlier sweep runs.
me=${SLURM_JOB_ID:-}
jobs=$(squeue -h -t PENDING,RUNNING,SUSPENDED -n "$tasks,$sweep" -o "%A %j")
while read -r id name; do
    if [ -z "$id" ] || [ "$id" = "$me" ]; then continue; fi
    if [ "$name" = "$tasks" ] || [ -z "$me" ] || [ "$id" -lt "$me" ]; then
        echo "job $id works on this dataset; nothing is submitted"
        exit 0
    fi
done <<< "$jobs"
rm -f .aula-*.part  # of killed tasks; no task runs now

missing=$("$aula" dataset status . --missing)
if [ -z "$missing" ]; then
    echo "all shards are complete"
    exit 0
fi
now=$(printf %s "$missing" | sha256sum)
if [ "$now" = "$before" ]; then idle=$((idle + 1)); else idle=0; fi
if [ "$idle" -ge 3 ]; then
    echo "no shard was completed in 3 rounds, missing: $missing" >&2
    exit 1
fi

# "3,998-1001" becomes the indices 3-3,998-999 of block 0 and 0-1 of block 1.
declare -A indices
IFS=, read -ra ranges <<< "$missing"
for range in "${ranges[@]}"; do
    first=${range%-*}
    last=${range#*-}
    while [ "$first" -le "$last" ]; do
        block=$((first / 1000))
        end=$((block * 1000 + 999))
        if [ "$end" -gt "$last" ]; then end=$last; fi
        indices[$block]+="${indices[$block]:+,}$((first % 1000))-$((end % 1000))"
        first=$((end + 1))
    done
done

arrays=""
for block in "${!indices[@]}"; do
    id=$(sbatch --parsable --array="${indices[$block]}%$limit" --output=slurm-logs/%A_%a.txt \
        --export=ALL,AULA_FIRST_SHARD=$((block * 1000)) slurm-array.sh)
    arrays+=":${id%%;*}"
done
sbatch --dependency="afterany${me:+:$me}$arrays" --output=slurm-logs/sweep-%j.txt slurm-sweep.sh \
    "$idle" "$now"
)sh";

}  // namespace

fs::path write_slurm_scripts(const Plan& plan, const SlurmOptions& options) {
    const fs::path folder = fs::canonical(plan.folder);
    const std::string variables = "\ndataset=" + shell_word(folder.string()) + "\naula=" +
                                  shell_word(fs::read_symlink("/proc/self/exe").string()) + "\n";
    // Names of jobs that belong to this folder only.
    const std::string key = sha256(folder.string()).substr(0, 8);
    const std::string tasks = "aula-dataset-" + key;
    const std::string sweeps = "aula-sweep-" + key;
    write_script(folder / "slurm-array.sh", directives(tasks, options.cpus, options.time) +
                                                variables + kTask + " --threads " +
                                                std::to_string(options.cpus) + "\n");
    const fs::path sweep = folder / "slurm-sweep.sh";
    write_script(sweep, directives(sweeps, 1, "01:00:00") + variables + "tasks=" + tasks +
                            "\nsweep=" + sweeps + "\nlimit=" + std::to_string(options.limit) +
                            "\n" + kSweep);
    return sweep;
}

}  // namespace aula
