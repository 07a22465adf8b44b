#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "apps/dataset/base/wav_bytes.h"
#include "apps/dataset/shards/shard_reader.h"
#include "apps/output/printable.h"
#include "aula/exception.h"
#include "tests/fuzz/dataset_target.h"

using namespace aula;

namespace {

/// The members of an archive, whatever its checksums are.
std::vector<std::pair<std::string, std::string>> members_of(std::string_view archive) {
    constexpr std::size_t kBlock = 512;
    constexpr std::size_t kSizeAt = 124;
    std::vector<std::pair<std::string, std::string>> members;
    while (archive.size() > kBlock && archive[0] != '\0' && members.size() < 8) {
        std::size_t size = 0;
        std::from_chars(archive.data() + kSizeAt, archive.data() + kSizeAt + 11, size, 8);
        size = std::min(size, archive.size() - kBlock);
        const std::string_view name = archive.substr(0, 100);
        members.emplace_back(name.substr(0, name.find('\0')), archive.substr(kBlock, size));
        archive.remove_prefix(std::min(archive.size(), kBlock + size + tar_padding(size).size()));
    }
    return members;
}

/// The archive with the checksums and hashes that its content has, and the hash of the plan.
std::string repaired(std::string_view archive) {
    std::vector<std::pair<std::string, std::string>> members = members_of(archive);
    std::string bytes;
    for (std::size_t m = 0; m < members.size(); ++m) {
        auto& [name, content] = members[m];
        const bool has_wav = m + 1 < members.size() && members[m + 1].first.ends_with(".wav");
        if (name.ends_with(".json"))
            content = test::resealed(test::of_plan(content), has_wav ? members[m + 1].second : "");
        bytes += test::archived(name, content);
    }
    return bytes + std::string(tar_end());
}

void read_shard() {
    const Plan& plan = test::fuzz_plan();
    try {
        ShardReader reader(plan, 0);
        while (reader.next()) {
            const ShardItem item = reader.read();
            test::expect(item.index == reader.item(), "an item has the number of its name");
            test::expect(item.json.ends_with("}\n"), "a description is a line");
            test::expect(item.error.empty() == reader.has_response(), "a response or an error");
            if (!reader.has_response()) {
                test::expect(printable_line(item.error) == item.error, "an error is one line");
                continue;
            }
            test::expect(item.box_m.has_value() != !item.scene_file.empty(), "a box or a file");
            test::expect(is_sha256(item.scene_sha256), "a hash has 64 digits");
            test::expect(item.t30_s.size() == plan.settings.array.size(), "T30 of microphones");
            test::expect(item.samples > 0 && item.samples == reader.samples(), "samples");
            const auto channels = wav_channels(item.wav, plan.settings.channels());
            for (const std::vector<float>& channel : channels)
                test::expect(channel.size() == item.samples &&
                                 std::all_of(channel.begin(), channel.end(),
                                             [](float x) { return std::isfinite(x); }),
                             "samples are finite");
        }
    } catch (const InputError& error) {
        test::expect_one_line(error.what());
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string name = test::fuzz_plan().shard_file(0).filename();
    test::input_file(name.c_str(), data, size);
    read_shard();
    test::fuzz_folder().write(
        name, repaired(std::string_view(reinterpret_cast<const char*>(data), size)));
    read_shard();
    return 0;
}
