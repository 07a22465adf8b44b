#include <filesystem>

#include "apps/dataset/merge/merge.h"
#include "aula/exception.h"
#include "tests/fuzz/dataset_target.h"

using namespace aula;

/// Merges items to the format of the first letter: w, h or s. The parts after it are descriptions
/// and responses in turn; an empty response is none.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::vector<std::string> parts =
        test::parts_of(std::string_view(reinterpret_cast<const char*>(data), size));
    const MergeFormat format = parts[0] == "h"   ? MergeFormat::hdf5
                               : parts[0] == "s" ? MergeFormat::sofa
                                                 : MergeFormat::wav;
    const Plan& plan = test::fuzz_plan();
    std::string archive;
    for (std::size_t p = 1; p < parts.size(); p += 2) {
        const std::string name = Plan::item_name(p / 2);
        const std::string wav = p + 1 < parts.size() ? parts[p + 1] : "";
        archive += test::archived(name + ".json", test::resealed(test::of_plan(parts[p]), wav));
        if (!wav.empty()) archive += test::archived(name + ".wav", wav);
    }
    test::fuzz_folder().write(plan.shard_file(0).filename(), archive + std::string(tar_end()));
    const auto folder_exists = [&] {
        for (const char* const name : {"wav", "hdf5", "sofa"})
            if (std::filesystem::remove_all(plan.folder / name) > 0) return true;
        return false;
    };
    try {
        test::expect(merge_dataset(plan, format, [] { return true; }), "a merge ends");
        test::expect(folder_exists(), "a merge has a folder");
    } catch (const InputError& error) {
        test::expect_one_line(error.what());
        test::expect(!folder_exists(), "a refused shard leaves no folder");
    }
    return 0;
}
