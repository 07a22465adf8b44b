#include "apps/dataset/merge/hdf5_target.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "apps/dataset/base/wav_bytes.h"
#include "apps/dataset/merge/hdf5_file.h"
#include "aula/exception.h"

namespace aula {

namespace {

constexpr const char* kFile = "responses.h5";

std::vector<double> coordinates(const PlannedPose& pose) {
    return {double{pose.position.x}, double{pose.position.y}, double{pose.position.z}};
}

class Hdf5Target : public MergeTarget {
 public:
    using Type = Hdf5File::Type;

    Hdf5Target(const Plan& plan, const MergeSizes& sizes, MergedFolder& folder)
        : folder_(folder),
          out_(folder.path(kFile), folder.named(kFile)),
          row_size_(plan.settings.channels()) {
        if (sizes.responses == 0)
            throw InputError(plan.folder.string(), "", "has no response; expected at least one");
        const DatasetSettings& s = plan.settings;
        samples_ = sizes.samples;
        const std::uint64_t rows = sizes.responses;
        for (const auto& [name, text] : std::vector<std::pair<std::string, std::string>>{
                 {"title", s.title},
                 {"licence", s.licence},
                 {"version", AULA_VERSION},
                 {"seed", std::to_string(s.seed)},
                 {"plan_sha256", plan.sha256},
                 {"format", format_name(s.format)},
                 {"sample_rate_hz", std::to_string(s.sample_rate_hz)}})
            out_.attribute(out_.root(), name, text);
        response_ = out_.create("response", Type::float32, {rows, row_size_, samples_});
        length_ = out_.create("samples", Type::int64, {rows});
        item_ = out_.create("item", Type::int64, {rows});
        scene_ = out_.create("scene", Type::int64, {rows});
        source_ = out_.create("source_position", Type::float64, {rows, 3});
        receiver_ = out_.create("receiver_position", Type::float64, {rows, 3});
        t30_ = out_.create("T30", Type::float64, {rows, s.array.size(), kBandCount});
        description_ = out_.create("description", Type::text, {rows});
    }

    void add(const ShardItem& item) override {
        std::vector<float> row;
        row.reserve(row_size_ * samples_);
        for (std::vector<float>& channel : wav_channels(item.wav, row_size_)) {
            channel.resize(samples_);
            row.insert(row.end(), channel.begin(), channel.end());
        }
        std::vector<double> t30_s;
        for (const auto& octaves : item.t30_s)
            t30_s.insert(t30_s.end(), octaves.begin(), octaves.end());
        out_.write_row(response_, row_, row);
        out_.write_row(length_, row_, static_cast<std::int64_t>(item.samples));
        out_.write_row(item_, row_, static_cast<std::int64_t>(item.index));
        out_.write_row(scene_, row_, static_cast<std::int64_t>(item.scene));
        out_.write_row(source_, row_, coordinates(item.source));
        out_.write_row(receiver_, row_, coordinates(item.receiver));
        out_.write_row(t30_, row_, t30_s);
        out_.write_row(description_, row_, item.json);
        ++row_;
    }

    void finish() override {
        out_.close();
        folder_.list(kFile);
    }

    std::string file_of(const ShardItem&) const override { return kFile; }

 private:
    MergedFolder& folder_;
    Hdf5File out_;
    std::uint64_t row_size_;  ///< channels
    std::uint64_t samples_ = 0;
    std::uint64_t row_ = 0;
    Hdf5File::Id response_, length_, item_, scene_, source_, receiver_, t30_, description_;
};

}  // namespace

std::unique_ptr<MergeTarget> make_hdf5_target(const Plan& plan, const MergeSizes& sizes,
                                              MergedFolder& folder) {
    return std::make_unique<Hdf5Target>(plan, sizes, folder);
}

}  // namespace aula
