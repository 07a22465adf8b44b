#include "apps/dataset/merge/merge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "apps/dataset/merge/hdf5_target.h"
#include "apps/dataset/merge/merge_target.h"
#include "apps/dataset/merge/merged_folder.h"
#include "apps/dataset/merge/sofa_target.h"
#include "apps/dataset/shards/status.h"
#include "apps/output/csv_text.h"
#include "apps/output/formatted.h"
#include "apps/output/json_text.h"
#include "apps/output/output_file.h"
#include "aula/exception.h"

namespace aula {

namespace {

const std::array<std::pair<const char*, MergeFormat>, 3> kFormats{
    {{"wav", MergeFormat::wav}, {"hdf5", MergeFormat::hdf5}, {"sofa", MergeFormat::sofa}}};

std::string format_folder(MergeFormat format) {
    for (const auto& [name, known] : kFormats)
        if (known == format) return name;
    return {};
}

/// The items as files, a thousand in each folder.
class WavTarget : public MergeTarget {
 public:
    explicit WavTarget(MergedFolder& folder) : folder_(folder) {}

    void add(const ShardItem& item) override {
        folder_.write(stem(item) + ".wav", item.wav);
        folder_.write(stem(item) + ".json", item.json);
    }
    void finish() override {}
    std::string file_of(const ShardItem& item) const override { return stem(item) + ".wav"; }

 private:
    static std::string stem(const ShardItem& item) {
        return formatted("%03llu/", static_cast<unsigned long long>(item.index / 1000)) +
               Plan::item_name(item.index);
    }

    MergedFolder& folder_;
};

std::unique_ptr<MergeTarget> make_target(const Plan& plan, MergeFormat format,
                                         const MergeSizes& sizes, MergedFolder& folder) {
    switch (format) {
        case MergeFormat::wav:
            break;
        case MergeFormat::hdf5:
            return make_hdf5_target(plan, sizes, folder);
        case MergeFormat::sofa:
            return make_sofa_target(plan, folder);
    }
    return std::make_unique<WavTarget>(folder);
}

std::string index_header() {
    std::string header =
        "item,scene,seed,file,source_x,source_y,source_z,receiver_x,receiver_y,"
        "receiver_z,samples,scene_sha256";
    for (const float centre_hz : kBandCentres_hz)
        header += formatted(",T30_%.0f", static_cast<double>(centre_hz));
    return header + "\n";
}

/// The line of an item in the index. T30 is that of the first microphone.
std::string index_line(const ShardItem& item, const std::string& file) {
    std::string line = std::to_string(item.index) + "," + std::to_string(item.scene) + "," +
                       std::to_string(item.seed) + "," + file;
    for (const PlannedPose& pose : {item.source, item.receiver})
        for (const float x : {pose.position.x, pose.position.y, pose.position.z})
            line += ',' + json_number(x);
    line += ',' + std::to_string(item.samples) + "," + item.scene_sha256;
    for (const double t30_s : item.t30_s[0])
        line += std::isnan(t30_s) ? "," : ',' + json_number(t30_s);
    return line + "\n";
}

std::string readme(const Plan& plan, const MergeSizes& sizes) {
    const DatasetSettings& s = plan.settings;
    return "# " + s.title + "\n\nlicence: " + s.licence +
           "\n\n| | |\n|---|---|\n| made by | Aula " + AULA_VERSION + " |\n| seed | " +
           std::to_string(s.seed) + " |\n| SHA-256 of the plan | " + plan.sha256 +
           " |\n| scenes | " + std::to_string(plan.scenes) + " |\n| items | " +
           std::to_string(plan.items) + " |\n| responses | " + std::to_string(sizes.responses) +
           " |\n| sample rate | " + std::to_string(s.sample_rate_hz) + " Hz |\n| format | " +
           format_name(s.format) + ", " + std::to_string(s.channels()) +
           " channels |\n\nindex.csv lists the responses and errors.csv the items without one; "
           "SHA256SUMS verifies all files.\n";
}

/// Reads the sizes of all shards. Throws InputError if one is missing.
MergeSizes measure_shards(const Plan& plan, const std::function<bool()>& continues) {
    MergeSizes sizes;
    std::vector<std::size_t> missing;
    std::string reason;  ///< of the first
    for (std::size_t shard = 0; shard < plan.shards.size() && continues(); ++shard) {
        try {
            ShardReader reader(plan, shard);
            while (reader.next()) {
                if (reader.has_response()) ++sizes.responses;
                sizes.samples = std::max(sizes.samples, reader.samples());
            }
        } catch (const InputError& error) {
            if (missing.empty()) reason = error.what();
            missing.push_back(shard);
        }
    }
    if (!missing.empty())
        throw InputError(plan.folder.string(), "",
                         "has no usable shard " + array_text(missing) +
                             "; expected all shards (aula dataset run): " + reason);
    return sizes;
}

[[noreturn]] void fail_changed(const Plan& plan, std::size_t shard) {
    throw InputError(plan.shard_file(shard).string(), "",
                     "has changed during the merge; expected no other process that writes it");
}

}  // namespace

std::optional<MergeFormat> merge_format(const std::string& name) {
    for (const auto& [known, format] : kFormats)
        if (name == known) return format;
    return std::nullopt;
}

bool merge_dataset(const Plan& plan, MergeFormat format, const std::function<bool()>& continues) {
    check_scenes(plan);
    const MergeSizes sizes = measure_shards(plan, continues);
    MergedFolder folder(plan.folder / format_folder(format));
    const std::unique_ptr<MergeTarget> target = make_target(plan, format, sizes, folder);
    OutputFile index(folder.path("index.csv"), folder.named("index.csv"));
    OutputFile errors(folder.path("errors.csv"), folder.named("errors.csv"));
    index.write(index_header());
    errors.write("item,error\n");
    std::uint64_t responses = 0;
    for (std::size_t shard = 0; shard < plan.shards.size(); ++shard) {
        ShardReader reader(plan, shard);
        while (continues() && reader.next()) {
            const ShardItem item = reader.read();
            if (!reader.has_response()) {
                errors.write(std::to_string(item.index) + "," + csv_quoted(item.error) + "\n");
                continue;
            }
            if (++responses > sizes.responses || item.samples > sizes.samples)
                fail_changed(plan, shard);
            target->add(item);
            index.write(index_line(item, target->file_of(item)));
        }
    }
    if (!continues()) return false;
    if (responses < sizes.responses) fail_changed(plan, plan.shards.size() - 1);
    target->finish();
    index.commit();
    errors.commit();
    folder.list("index.csv");
    folder.list("errors.csv");
    folder.write("README.md", readme(plan, sizes));
    folder.commit();
    return true;
}

}  // namespace aula
