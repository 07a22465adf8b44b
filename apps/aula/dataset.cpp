#include <chrono>
#include <cstdio>
#include <string>

#include "apps/aula/commands.h"
#include "apps/aula/terminal/interrupt.h"
#include "apps/aula/terminal/terminal.h"
#include "apps/dataset/merge/merge.h"
#include "apps/dataset/plan/plan_reader.h"
#include "apps/dataset/shards/shard.h"
#include "apps/dataset/shards/slurm.h"
#include "apps/dataset/shards/status.h"
#include "apps/output/formatted.h"
#include "apps/output/printable.h"
#include "aula/exception.h"

namespace aula {

namespace {

bool continues() { return interrupt_signal() == 0; }

int plan_dataset(const DatasetArguments& arguments) {
    const Manifest manifest = read_manifest(arguments.manifest);
    {
        const TaskLine line("planning", !arguments.quiet);
        if (!write_plan(manifest, arguments.folder, arguments.shards, continues))
            return interrupted_status();
    }
    const Plan plan = read_plan(arguments.folder);
    if (!arguments.quiet)
        std::printf("%s in %s and %s, SHA-256 of the plan %s\n",
                    counted(plan.items, "item").c_str(), counted(plan.scenes, "scene").c_str(),
                    counted(plan.shards.size(), "shard").c_str(), plan.sha256.c_str());
    if (plan.empty_scenes > 0)
        warn({std::to_string(plan.empty_scenes) + " of " + counted(plan.scenes, "scene") +
              std::string(plan.empty_scenes == 1 ? " has" : " have") +
              " no positions with the clearances: no responses"},
             arguments.quiet);
    return 0;
}

int run_dataset(const DatasetArguments& arguments) {
    const Plan plan = read_plan(arguments.folder);
    if (arguments.shard >= plan.shards.size())
        throw InputError("--shard: " + std::to_string(arguments.shard) +
                         " is not a shard; expected 0 to " +
                         std::to_string(plan.shards.size() - 1));
    if (find_shard(plan, arguments.shard)) return 0;
    const std::string name = plan.shard_file(arguments.shard).filename().string();
    const auto start = std::chrono::steady_clock::now();
    std::optional<ShardContents> contents;
    {
        StatusLine line(!arguments.quiet);
        const ShardRange& range = plan.shards[arguments.shard];
        contents = compute_shard(plan, arguments.shard, arguments.threads, continues,
                                 [&](std::uint64_t items) {
                                     line.show(name + ": " + std::to_string(items) + " of " +
                                               counted(range.end_item - range.first_item, "item"));
                                 });
    }
    if (!contents) return interrupted_status();
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    if (!arguments.quiet)
        std::printf("%s: %s, %s, %.1f responses per second\n", name.c_str(),
                    counted(contents->responses, "response").c_str(),
                    counted(contents->errors, "error").c_str(),
                    static_cast<double>(contents->responses) / elapsed.count());
    return 0;
}

int show_status(const DatasetArguments& arguments) {
    const Plan plan = read_plan(arguments.folder);
    const DatasetStatus status = dataset_status(plan, arguments.verify, continues);
    if (!continues()) return interrupted_status();
    if (arguments.missing) {
        if (!status.missing.empty()) std::printf("%s\n", array_text(status.missing).c_str());
        return 0;
    }
    std::printf("%zu of %s complete\n", plan.shards.size() - status.missing.size(),
                counted(plan.shards.size(), "shard").c_str());
    std::printf(
        "%llu of %s with a response, %s\n", static_cast<unsigned long long>(status.responses),
        counted(plan.items, "item").c_str(), counted(status.failures.size(), "error").c_str());
    for (const auto* const lines : {&status.damaged, &status.failures})
        for (const std::string& line : *lines) std::printf("%s\n", printable_line(line).c_str());
    return 0;
}

int write_slurm(const DatasetArguments& arguments) {
    const Plan plan = read_plan(arguments.folder);
    const std::filesystem::path sweep = write_slurm_scripts(plan, arguments.slurm);
    if (!arguments.quiet) std::printf("sbatch %s\n", sweep.string().c_str());
    return 0;
}

int merge(const DatasetArguments& arguments) {
    const Plan plan = read_plan(arguments.folder);
    const TaskLine line("merging", !arguments.quiet);
    return merge_dataset(plan, arguments.format, continues) ? 0 : interrupted_status();
}

}  // namespace

int dataset(const DatasetArguments& arguments) {
    using Command = DatasetArguments::Command;
    switch (arguments.command) {
        case Command::plan:
            return plan_dataset(arguments);
        case Command::run:
            return run_dataset(arguments);
        case Command::status:
            return show_status(arguments);
        case Command::slurm:
            return write_slurm(arguments);
        case Command::merge:
            return merge(arguments);
    }
    return 1;
}

}  // namespace aula
