#include "apps/dataset/merge/sofa_target.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "apps/dataset/base/wav_bytes.h"
#include "apps/dataset/merge/hdf5_file.h"
#include "apps/output/formatted.h"
#include "aula/exception.h"

namespace aula {

namespace {

using Texts = std::vector<std::pair<std::string, std::string>>;

const Texts kCartesian{{"Type", "cartesian"}, {"Units", "metre"}};

std::vector<double> numbers(const Vec3& v) { return {double{v.x}, double{v.y}, double{v.z}}; }

/// One SOFA file.
class SofaFile {
 public:
    SofaFile(const MergedFolder& folder, const std::string& file, const Plan& plan,
             const std::vector<ShardItem>& items)
        : plan_(plan), items_(items), out_(folder.path(file), folder.named(file)) {
        std::size_t samples = 1;
        for (const ShardItem& item : items)
            samples = std::max(samples, static_cast<std::size_t>(item.samples));
        write_attributes();
        const std::size_t channels = plan.settings.channels();
        for (const auto& [name, size] :
             std::vector<std::pair<char, std::uint64_t>>{{'M', items.size()},
                                                         {'R', channels},
                                                         {'N', samples},
                                                         {'E', 1},
                                                         {'I', 1},
                                                         {'C', 3}})
            dimensions_.push_back({name, size, out_.dimension(std::string(1, name), size)});
        write_positions();
        write_receivers();
        write_responses(channels, samples);
        out_.close();
    }

 private:
    struct Dimension {
        char name;
        std::uint64_t size;
        Hdf5File::Id id;
    };

    /// A variable with the dimensions of the given names.
    Hdf5File::Id variable(const std::string& name, const std::string& dimensions,
                          const Texts& attributes, Hdf5File::Type type = Hdf5File::Type::float64) {
        std::vector<std::uint64_t> size;
        std::vector<Hdf5File::Id> ids;
        for (const char letter : dimensions)
            for (const Dimension& dimension : dimensions_)
                if (dimension.name == letter) {
                    size.push_back(dimension.size);
                    ids.push_back(dimension.id);
                }
        const Hdf5File::Id id = out_.create(name, type, size);
        out_.attach(id, ids);
        for (const auto& [key, text] : attributes) out_.attribute(id, key, text);
        return id;
    }

    /// Three numbers for each measurement.
    template <typename Of>
    void vectors(const std::string& name, const Texts& attributes, const Of& of) {
        const Hdf5File::Id id = variable(name, "MC", attributes);
        for (std::size_t m = 0; m < items_.size(); ++m)
            out_.write_row(id, m, numbers(of(items_[m])));
    }

    void write_attributes() {
        const DatasetSettings& s = plan_.settings;
        const bool box = items_[0].box_m.has_value();
        Texts texts{{"Conventions", "SOFA"},
                    {"Version", "2.1"},
                    {"SOFAConventions", "SingleRoomSRIR"},
                    {"SOFAConventionsVersion", "1.0"},
                    {"DataType", "FIR"},
                    {"RoomType", box ? "shoebox" : "dae"},
                    {"Title", s.title},
                    {"DateCreated", s.date + " 00:00:00"},
                    {"DateModified", s.date + " 00:00:00"},
                    {"APIName", "Aula"},
                    {"APIVersion", AULA_VERSION},
                    {"AuthorContact", "none"},
                    {"Organization", "none"},
                    {"License", s.licence},
                    {"ApplicationName", "Aula"},
                    {"ApplicationVersion", AULA_VERSION},
                    {"Comment", "seed " + std::to_string(items_[0].seed)},
                    {"Origin", "simulated"},
                    {"DatabaseName", s.title}};
        if (!box) texts.emplace_back("RoomGeometry", items_[0].scene_file);
        for (const auto& [name, text] : texts) out_.attribute(out_.root(), name, text);
    }

    void write_positions() {
        const auto view = [](const PlannedPose& pose) { return pose.pose().rotation()[0]; };
        const auto up = [](const PlannedPose& pose) { return pose.pose().rotation()[2]; };
        vectors("ListenerPosition", kCartesian,
                [](const ShardItem& item) { return item.receiver.position; });
        vectors("ListenerView", kCartesian, [&](const ShardItem& i) { return view(i.receiver); });
        vectors("ListenerUp", {}, [&](const ShardItem& i) { return up(i.receiver); });
        vectors("SourcePosition", kCartesian,
                [](const ShardItem& item) { return item.source.position; });
        vectors("SourceView", kCartesian, [&](const ShardItem& i) { return view(i.source); });
        vectors("SourceUp", {}, [&](const ShardItem& i) { return up(i.source); });
        const Hdf5File::Id emitter = variable("EmitterPosition", "ECI", kCartesian);
        out_.write_row(emitter, 0, numbers(Vec3(0)));
        if (items_[0].box_m) write_corners(*items_[0].box_m);
    }

    void write_corners(const std::array<double, 3>& size_m) {
        const Hdf5File::Id low = variable("RoomCornerA", "IC", {});
        out_.write_row(low, 0, numbers(Vec3(0)));
        const Hdf5File::Id high = variable("RoomCornerB", "IC", {});
        out_.write_row(high, 0, std::vector<double>(size_m.begin(), size_m.end()));
        const Hdf5File::Id corners = variable("RoomCorners", "I", kCartesian);
        out_.write_row(corners, 0, std::vector<double>{0});
    }

    /// The positions of the channels relative to the listener. Ambisonic channels have the type
    /// "spherical harmonics", in ACN order; binaural ones are 9 cm from the centre of the head.
    void write_receivers() {
        const DatasetSettings& s = plan_.settings;
        const bool ambisonic = s.format == OutputFormat::foa || s.format == OutputFormat::toa;
        const Texts harmonics{{"Type", "spherical harmonics"}, {"Units", "degree, degree, metre"}};
        const Hdf5File::Id id =
            variable("ReceiverPosition", "RCI", ambisonic ? harmonics : kCartesian);
        const std::size_t each = channel_count(s.format);
        constexpr float kEar_m = 0.09F;
        for (std::size_t r = 0; r < s.channels(); ++r) {
            Vec3 position = s.array[r / each];
            if (s.format == OutputFormat::binaural) position.y += r % each == 0 ? kEar_m : -kEar_m;
            out_.write_row(id, r, numbers(position));
        }
    }

    void write_responses(std::size_t channels, std::size_t samples) {
        const Hdf5File::Id rate = variable("Data.SamplingRate", "I", {{"Units", "hertz"}});
        out_.write_row(rate, 0, std::vector{double(plan_.settings.sample_rate_hz)});
        const Hdf5File::Id delay = variable("Data.Delay", "IR", {});
        out_.write_row(delay, 0, std::vector<double>(channels));
        const Hdf5File::Id responses = variable("Data.IR", "MRN", {}, Hdf5File::Type::float32);
        for (std::size_t m = 0; m < items_.size(); ++m) {
            std::vector<float> row;
            row.reserve(channels * samples);
            for (std::vector<float>& channel : wav_channels(items_[m].wav, channels)) {
                channel.resize(samples);
                row.insert(row.end(), channel.begin(), channel.end());
            }
            out_.write_row(responses, m, row);
        }
    }

    const Plan& plan_;
    const std::vector<ShardItem>& items_;
    Hdf5File out_;
    std::vector<Dimension> dimensions_;
};

class SofaTarget : public MergeTarget {
 public:
    SofaTarget(const Plan& plan, MergedFolder& folder) : plan_(plan), folder_(folder) {
        const OutputFormat format = plan.settings.format;
        const bool ambisonic = format == OutputFormat::foa || format == OutputFormat::toa;
        if (ambisonic && plan.settings.array.size() > 1)
            throw InputError(
                "--to: ambisonic responses of an array have no SOFA file; expected "
                "hdf5 or wav");
    }

    void add(const ShardItem& item) override {
        if (!items_.empty() && items_[0].scene != item.scene) write();
        items_.push_back(item);
    }

    void finish() override {
        if (!items_.empty()) write();
    }

    std::string file_of(const ShardItem& item) const override {
        return formatted("scene-%06llu.sofa", static_cast<unsigned long long>(item.scene));
    }

 private:
    void write() {
        const std::string name = file_of(items_[0]);
        const SofaFile file(folder_, name, plan_, items_);
        folder_.list(name);
        items_.clear();
    }

    const Plan& plan_;
    MergedFolder& folder_;
    std::vector<ShardItem> items_;  ///< of one scene
};

}  // namespace

std::unique_ptr<MergeTarget> make_sofa_target(const Plan& plan, MergedFolder& folder) {
    return std::make_unique<SofaTarget>(plan, folder);
}

}  // namespace aula
