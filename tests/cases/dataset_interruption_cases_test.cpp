#include <catch2/catch.hpp>
#include <cstdlib>
#include <random>

#include "tests/cases/killed_program.h"
#include "tests/dataset/small_dataset.h"

namespace {

using namespace aula::test;
namespace fs = std::filesystem;

/// A dataset with an earlier merge, and the shards of another plan of the same size.
class MergedTwice {
 public:
    explicit MergedTwice(const std::string& format) : format_(format) {
        const TemporaryFolder other;
        out_ = make_dataset(folder_, box_manifest(2), "out", 1);
        earlier_sums_ = merged_sums(out_, format);
        earlier_ = contents_of(merged());
        std::string manifest = box_manifest(2);
        manifest.replace(manifest.find("\"seed\": 5"), 9, "\"seed\": 6");
        const fs::path next = make_dataset(other, manifest, "out", 1);
        for (const char* const file : {"plan.json", "plan.jsonl", "shard-00000.tar"})
            fs::copy_file(next / file, out_ / file, fs::copy_options::overwrite_existing);
        sums_ = merged_sums(out_, format);
        CHECK(sums_ != earlier_sums_);
        names_ = names_in(out_);
    }

    std::vector<std::string> merge() const {
        return {AULA_PROGRAM, "dataset", "merge", out_, "--to", format_};
    }

    fs::path merged() const { return out_ / format_; }
    void restore_earlier() const { restore(merged(), earlier_); }

    /// Checks a merged folder: the earlier one or the new one, with all files and no others.
    void check_whole(const fs::path& folder) const {
        const std::string sums = read_file(folder / "SHA256SUMS");
        CHECK((sums == sums_ || sums == earlier_sums_));
        const ProgramResult result =
            run_program({"sh", "-c", "cd \"$0\" && sha256sum -c --quiet SHA256SUMS", folder});
        INFO(result.out << result.err);
        CHECK(result.status == 0);
        // All files but SHA256SUMS have a line.
        std::size_t files = 0;
        for (const auto& entry : fs::recursive_directory_iterator(folder))
            if (!entry.is_directory()) ++files;
        CHECK(static_cast<std::size_t>(std::count(sums.begin(), sums.end(), '\n')) == files - 1);
    }

    /// The next merge succeeds and leaves nothing behind.
    void check_next_merge() const {
        const ProgramResult result = run_program(merge());
        INFO(result.err);
        CHECK(result.status == 0);
        CHECK(read_file(merged() / "SHA256SUMS") == sums_);
        CHECK(names_in(out_) == names_);
        check_whole(merged());
    }

 private:
    TemporaryFolder folder_;
    std::string format_;
    fs::path out_;
    FolderContents earlier_;
    std::string earlier_sums_, sums_;
    std::vector<std::string> names_;
};

}  // namespace

TEST_CASE("a merge that is killed at each removal, renaming and flush leaves a whole dataset") {
    const MergedTwice dataset("wav");
    bool was_killed = true;
    long at = 1;
    for (; was_killed; ++at) {
        CAPTURE(at);
        dataset.restore_earlier();
        was_killed = killed(dataset.merge(), {}, at);
        dataset.check_whole(dataset.merged());
        dataset.check_next_merge();
    }
    // The earlier folder has 12 files and a folder.
    CHECK(at > 13);
}

TEST_CASE("where names cannot be exchanged a killed merge leaves a whole dataset for the next") {
    const MergedTwice dataset("wav");
    int aside = 0;
    bool was_killed = true;
    for (long at = 1; was_killed; ++at) {
        CAPTURE(at);
        dataset.restore_earlier();
        was_killed = killed(dataset.merge(), {.exchanges = false}, at);
        // Between the two renamings the earlier dataset has the name of neither.
        if (!fs::exists(dataset.merged())) ++aside;
        dataset.check_whole(fs::exists(dataset.merged())
                                ? dataset.merged()
                                : dataset.merged().parent_path() / ".aula-wav.old");
        dataset.check_next_merge();
    }
    CHECK(aside == 1);
}

// AULA_MERGE_KILLS merges are killed, by default 200.
TEST_CASE("merges that are killed at random calls leave a whole dataset") {
    const char* const asked = std::getenv("AULA_MERGE_KILLS");
    const int kills = asked != nullptr ? std::atoi(asked) : 200;
    const Kill kill{.calls = Kill::Calls::all};
    std::minstd_rand random(40);
    for (const std::string format : {"wav", "hdf5", "sofa"}) {
        const MergedTwice dataset(format);
        const long calls = calls_of(dataset.merge(), kill);
        std::uniform_int_distribution<long> at_random(1, calls);
        for (int i = 0; i < kills / 3 + 1; ++i) {
            const long at = at_random(random);
            CAPTURE(format, at, calls);
            dataset.restore_earlier();
            CHECK(killed(dataset.merge(), kill, at));
            dataset.check_whole(dataset.merged());
            dataset.check_next_merge();
        }
    }
}

TEST_CASE("a plan that replaces another one and is killed leaves one of them, whole") {
    const TemporaryFolder folder;
    const fs::path out = folder.path() / "out";
    const std::string earlier = folder.write("earlier.json", box_manifest(3));
    const std::string next = folder.write("next.json", box_manifest(4));
    const auto plan = [&](const std::string& manifest) {
        return std::vector<std::string>{"plan", manifest, "--out", out, "--shards", "2"};
    };
    require_dataset(plan(next));
    const FolderContents planned = contents_of(out);
    bool was_killed = true;
    for (long at = 1; was_killed; ++at) {
        CAPTURE(at);
        fs::remove_all(out);
        require_dataset(plan(earlier));
        std::vector<std::string> command = plan(next);
        command.insert(command.begin(), {AULA_PROGRAM, "dataset"});
        was_killed = killed(command, {}, at);
        const std::string status = require_dataset({"status", out}).out;
        CHECK((status.find("0 of 6 items") != std::string::npos ||
               status.find("0 of 8 items") != std::string::npos));
        require_dataset(plan(next));
        CHECK(contents_of(out) == planned);
    }
}

TEST_CASE("a task that is killed leaves no shard or a whole one, and the next leaves only it") {
    const TemporaryFolder folder;
    const fs::path out = make_dataset(folder, box_manifest(2), "out", 1);
    const FolderContents complete = contents_of(out);
    bool was_killed = true;
    for (long at = 1; was_killed; ++at) {
        CAPTURE(at);
        fs::remove(out / "shard-00000.tar");
        was_killed = killed({AULA_PROGRAM, "dataset", "run", out, "--shard", "0"}, {}, at);
        const std::string shard = read_file(out / "shard-00000.tar");
        CHECK((shard.empty() || shard == complete.at("shard-00000.tar")));
        run_shards(out, 1);
        CHECK(contents_of(out) == complete);
    }
}
