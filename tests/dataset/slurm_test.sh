#!/bin/bash
# slurm_test.sh AULA FOLDER KILLS: computes the dataset of FOLDER/manifest.json by Slurm into
# FOLDER/slurm, while KILLS tasks are killed at random times and one is cancelled.
set -euo pipefail
aula=$1 folder=$2 kills=$3
out=$folder/slurm
"$aula" dataset plan "$folder/manifest.json" --out "$out" --shards $((4 + kills)) --quiet
"$aula" dataset slurm "$out" --limit 2 --time 00:10:00 --quiet
# Twice, as by mistake: the second one ends.
sbatch --output=/dev/null "$out/slurm-sweep.sh" > /dev/null
sbatch --output="$folder/second.txt" "$out/slurm-sweep.sh" > /dev/null
RANDOM=7
killed=0
cancelled=0
while [ -n "$(squeue -h)" ]; do
    sleep "0.$((RANDOM % 5))1"
    mapfile -t tasks < <(pgrep -f "dataset run $out --shard" || true)
    [ "${#tasks[@]}" -gt 0 ] || continue
    if [ "$cancelled" = 0 ]; then
        running=$(squeue -h -t R -o "%i %j" | awk "/ aula-dataset-/ {print \$1; exit}")
        if [ -n "$running" ]; then
            scancel "$running"
            cancelled=1
        fi
    elif [ "$killed" -lt "$kills" ]; then
        kill -9 "${tasks[$((RANDOM % ${#tasks[@]}))]}" 2> /dev/null && killed=$((killed + 1))
    fi
done
echo "killed $killed cancelled $cancelled sweeps $(ls "$out"/slurm-logs/sweep-*.txt | wc -l)"
