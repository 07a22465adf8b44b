#include "tests/aula/matrix_case.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "aula/audio/sound_file.h"
#include "tests/aula/random_values.h"

namespace aula::test {

namespace {

using Json = nlohmann::ordered_json;

using Point = std::array<double, 3>;

double distance(const Point& a, const Point& b) {
    return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// A position, or a path of positions.
struct Course {
    std::vector<Point> points;
    Json path;  ///< null: static at points[0]
};

class CaseMaker {
 public:
    CaseMaker(std::uint64_t seed, std::filesystem::path folder)
        : random_(seed), directivities_(seed + 1'000'000), folder_(std::move(folder)) {}

    MatrixCase make() {
        scene_["aula"] = 1;
        make_room();
        make_screens();
        make_medium();
        make_sources();
        make_listener();
        choose_sound();
        choose_simulation();
        choose_mode();
        for (auto& [key, value] : simulation_.items()) add_setting(key, value);
        std::ofstream(folder_ / "scene.json") << scene_.dump(2) << '\n';
        case_.command.insert(case_.command.begin(), {"aula", (folder_ / "scene.json").string()});
        case_.command.emplace_back("--quiet");
        return case_;
    }

 private:
    /// Writes a setting to the scene file or to the command line.
    void add_setting(const std::string& key, const Json& value) {
        static const std::vector<std::pair<std::string, std::string>> kOptions = {
            {"estimator", "--estimator"},
            {"rays", "--rays"},
            {"order", "--order"},
            {"specular_order", "--specular-order"},
            {"response_time_s", "--response-time"},
            {"patch_size_m", "--patch-size"},
            {"listener_radius_m", "--listener-radius"},
            {"frame_rate_hz", "--frame-rate"},
            {"ir_length_s", "--ir-length"},
            {"seed", "--seed"},
            {"threads", "--threads"},
            {"memory_mb", "--memory-mb"}};
        const auto option = std::find_if(kOptions.begin(), kOptions.end(),
                                         [&](const auto& entry) { return entry.first == key; });
        if (option != kOptions.end() && random_.chance(0.5)) {
            case_.command.push_back(option->second);
            case_.command.push_back(value.is_string() ? value.get<std::string>() : value.dump());
            return;
        }
        scene_["simulation"][key] = value;
    }

    Json random_bands() {
        if (random_.chance(0.5)) return random_.uniform(0, 1);
        Json bands = Json::array();
        for (int b = 0; b < 8; ++b)
            bands.push_back(random_.chance(0.1) ? random_.pick({0.0, 1.0}) : random_.uniform(0, 1));
        return bands;
    }

    std::string material() {
        if (random_.chance(0.4))
            return random_.pick<const char*>({"plaster", "concrete", "carpet", "glass", "curtain",
                                              "wood", "audience", "marble"});
        const std::string name = "m" + std::to_string(++materials_);
        Json& made = scene_["materials"][name];
        // Lossless walls take the longest time.
        made["absorption"] = random_.chance(0.07) ? Json(0) : random_bands();
        if (random_.chance(0.8))
            made["scattering"] = random_.chance(0.15) ? Json(0) : random_bands();
        if (random_.chance(0.3)) transmit(made);
        return name;
    }

    /// Adds a sound reduction, if the material absorbs in every band.
    void transmit(Json& made) {
        double least = 1;
        for (const Json& share :
             made["absorption"].is_array() ? made["absorption"] : Json{made["absorption"]})
            least = std::min(least, share.get<double>());
        if (least < 1e-6) return;
        // A little more than the absorption allows, as the file's numbers are rounded.
        made["sound_reduction_db"] = -10 * std::log10(least) + random_.uniform(0.01, 50);
    }

    void add(Json geometry) {
        geometry["material"] = material();
        scene_["geometry"].push_back(std::move(geometry));
    }

    void make_room() {
        for (std::size_t axis = 0; axis < 3; ++axis)
            size_[axis] = random_.log_uniform(2, axis == 2 ? 12 : 30);
        for (double& corner : least_) corner = random_.chance(0.5) ? 0 : random_.uniform(-50, 50);
        switch (random_.integer(0, 9)) {
            case 0:  // free field
                return;
            case 1:
                make_cave();
                return;
            case 2:
                make_angle();
                return;
            case 3:
                make_open();
                return;
            default:
                add({{"box", size_}, {"min", least_}});
        }
    }

    /// A box around the room with uneven walls of many planes.
    void make_cave() {
        const int cells = random_.integer(2, 9);
        Json vertices = Json::array();
        Json faces = Json::array();
        for (std::size_t side = 0; side < 6; ++side) {
            const std::size_t normal = side / 2;
            const int first = static_cast<int>(vertices.size());
            for (int i = 0; i <= cells; ++i) {
                for (int k = 0; k <= cells; ++k) {
                    const bool edge = i == 0 || k == 0 || i == cells || k == cells;
                    Point p;
                    p[normal] = side % 2 == 0 ? 0 : size_[normal];
                    // Outwards: points in the room stay inside.
                    const double out = edge ? 0 : random_.uniform(0, 0.1 * size_[normal]);
                    p[normal] += side % 2 == 0 ? -out : out;
                    p[(normal + 1) % 3] = size_[(normal + 1) % 3] * i / cells;
                    p[(normal + 2) % 3] = size_[(normal + 2) % 3] * k / cells;
                    for (std::size_t axis = 0; axis < 3; ++axis) p[axis] += least_[axis];
                    vertices.push_back(p);
                }
            }
            const auto at = [&](int i, int k) { return first + i * (cells + 1) + k; };
            for (int i = 0; i < cells; ++i) {
                for (int k = 0; k < cells; ++k) {
                    faces.push_back({at(i, k), at(i + 1, k), at(i + 1, k + 1)});
                    faces.push_back({at(i, k), at(i + 1, k + 1), at(i, k + 1)});
                }
            }
        }
        add({{"vertices", vertices}, {"faces", faces}});
    }

    /// An L-shaped room; all positions are in one of its arms, which is convex.
    void make_angle() {
        const double x = size_[0];
        const double y = size_[1];
        const std::vector<std::array<double, 2>> corners{{0, 0},         {x, 0},     {x, 2 * y},
                                                         {x / 2, 2 * y}, {x / 2, y}, {0, y}};
        Json vertices = Json::array();
        for (const double z : {0.0, size_[2]})
            for (const auto& corner : corners)
                vertices.push_back({least_[0] + corner[0], least_[1] + corner[1], least_[2] + z});
        Json faces = {{0, 1, 2, 3, 4, 5}, {6, 7, 8, 9, 10, 11}};
        for (int i = 0; i < 6; ++i) {
            const int next = (i + 1) % 6;
            faces.push_back({i, next, next + 6, i + 6});
        }
        add({{"vertices", vertices}, {"faces", faces}});
    }

    /// Some walls of a box.
    void make_open() {
        Json vertices = Json::array();
        for (unsigned corner = 0; corner < 8; ++corner) {
            Point p = least_;
            for (std::size_t axis = 0; axis < 3; ++axis)
                if ((corner >> axis & 1U) != 0) p[axis] += size_[axis];
            vertices.push_back(p);
        }
        const Json all = {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4},
                          {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}};
        Json faces = Json::array();
        faces.push_back(all[0]);
        for (std::size_t f = 1; f < all.size(); ++f)
            if (random_.chance(0.6)) faces.push_back(all[f]);
        add({{"vertices", vertices}, {"faces", faces}});
    }

    Point inside() {
        Point p;
        for (std::size_t axis = 0; axis < 3; ++axis)
            p[axis] = least_[axis] + size_[axis] * random_.uniform(0.05, 0.95);
        return p;
    }

    /// Static and moving screens, which occlude positions.
    void make_screens() {
        if (random_.chance(0.6)) return;
        screens_ = random_.integer(1, 3);
        for (int s = 0; s < screens_; ++s) {
            const double width = random_.uniform(0.2, 0.6) * size_[0];
            const double height = random_.uniform(0.2, 0.9) * size_[2];
            Json screen;
            screen["name"] = "screen " + std::to_string(s);
            screen["vertices"] = {{0, 0, 0}, {width, 0, 0}, {width, 0, height}, {0, 0, height}};
            screen["faces"] = Json::array();
            screen["faces"].push_back({0, 1, 2, 3});
            const Course course = random_course(0.5);
            if (course.path.is_null())
                screen["translate"] = course.points[0];
            else
                screen["path"] = course.path;
            add(std::move(screen));
        }
    }

    void make_medium() {
        if (random_.chance(0.7)) return;
        scene_["medium"] = {{"temperature_c", random_.uniform(-10, 40)},
                            {"humidity_percent", random_.uniform(5, 100)},
                            {"pressure_kpa", random_.uniform(80, 108)},
                            {"air_absorption", random_.chance(0.7)}};
    }

    Course random_course(double moving) {
        Course course;
        course.points.push_back(inside());
        if (!random_.chance(moving)) return course;
        Json points = Json::array();
        double time_s = random_.chance(0.7) ? 0 : random_.uniform(0, 0.5);
        const int count = random_.integer(1, 5);
        for (int i = 0; i < count; ++i) {
            if (i > 0) course.points.push_back(inside());
            Json point{{"t", time_s}, {"position", course.points.back()}};
            if (random_.chance(0.5)) point["yaw_deg"] = random_.uniform(-400, 400);
            if (random_.chance(0.2)) point["pitch_deg"] = random_.uniform(-90, 90);
            if (random_.chance(0.2)) point["roll_deg"] = random_.uniform(-180, 180);
            points.push_back(point);
            // Some move faster than sound.
            time_s += random_.log_uniform(0.01, 3);
        }
        moves_ = true;
        course.path = {{"points", points}, {"loop", count > 1 && random_.chance(0.4)}};
        return course;
    }

    void make_sources() {
        const int count = random_.chance(0.5) ? random_.integer(1, 2) : random_.integer(1, 7);
        for (int s = 0; s < count; ++s) {
            Json source;
            source["name"] = s == 3 ? "naïve /source\\ 3" : "s" + std::to_string(s);
            const Course course = random_course(0.4);
            source["position"] = course.points[0];
            if (!course.path.is_null()) source["path"] = course.path;
            source_points_.push_back(course.points);
            switch (random_.integer(0, 3)) {
                case 0:
                    source["signal"] = "impulse";
                    source["loop"] = random_.chance(0.5);
                    break;
                case 1:
                    source["signal"] = sound_file();
                    source["loop"] = random_.chance(0.5);
                    if (source["loop"] == false)
                        longest_unlooped_s_ = std::max(longest_unlooped_s_, sound_s_);
                    break;
                default:
                    source["signal"] = "noise";
            }
            if (random_.chance(0.5)) source["gain_db"] = random_.uniform(-20, 10);
            // Directivities that are silent in no direction.
            if (directivities_.chance(0.5)) {
                source["directivity"] =
                    directivities_.pick<const char*>({"subcardioid", "talker", "loudspeaker"});
                source["yaw_deg"] = directivities_.uniform(-400, 400);
                source["pitch_deg"] = directivities_.uniform(-100, 100);
            }
            scene_["sources"].push_back(source);
        }
    }

    /// Writes a file of noise with a random sample rate and number of channels.
    std::string sound_file() {
        const double rate_hz = random_.pick({8000.0, 22050.0, 44100.0, 48000.0, 96000.0});
        const auto channels = static_cast<std::size_t>(random_.integer(1, 3));
        const auto frames =
            static_cast<std::size_t>(std::max(16.0, random_.log_uniform(0.005, 2) * rate_hz));
        const std::string name = "sound" + std::to_string(++sounds_) + ".wav";
        WavWriter writer(folder_ / name, rate_hz, channels,
                         random_.pick({SampleFormat::float32, SampleFormat::pcm16}));
        std::vector<float> samples(frames * channels);
        for (float& sample : samples) sample = static_cast<float>(random_.uniform(-0.3, 0.3));
        writer.write(samples);
        writer.commit();
        sound_s_ = static_cast<double>(frames) / rate_hz;
        return name;
    }

    void make_listener() {
        Course course = random_course(0.5);
        // Sometimes at the position of a source.
        if (random_.chance(0.05)) {
            course.points = {source_points_[0][0]};
            course.path = nullptr;
        }
        Json listener;
        listener["position"] = course.points[0];
        if (random_.chance(0.5)) listener["yaw_deg"] = random_.uniform(-180, 180);
        if (!course.path.is_null()) listener["path"] = course.path;
        scene_["listener"] = listener;
        for (const auto& points : source_points_)
            for (const Point& a : points)
                for (const Point& b : course.points)
                    farthest_m_ = std::max(farthest_m_, distance(a, b));
    }

    void option(const std::string& name, const std::string& value) {
        case_.command.push_back(name);
        case_.command.push_back(value);
    }

    void choose_sound() {
        case_.sample_rate_hz =
            random_.chance(0.5)
                ? 48000
                : random_.pick({8000, 11025, 16000, 22050, 44100, 45678, 96000, 192000});
        if (case_.sample_rate_hz != 48000 || random_.chance(0.2))
            option("--sample-rate", std::to_string(std::lround(case_.sample_rate_hz)));
        if (random_.chance(0.6)) option("--block", std::to_string(1 << random_.integer(4, 13)));
        const std::string output = random_.pick<const char*>({"binaural", "mono", "foa"});
        if (output != "binaural" || random_.chance(0.3)) option("--output", output);
        case_.channels = output == "binaural" ? 2 : output == "mono" ? 1 : 4;
        field_channels_ = output == "mono" ? 1 : 4;
        if (output == "binaural" && random_.chance(0.4)) {
            const int order = random_.integer(1, 3);
            option("--ambisonic-order", std::to_string(order));
            field_channels_ = (order + 1) * (order + 1);
        }
        if (random_.chance(0.2)) case_.command.emplace_back("--half-precision-tail");
    }

    /// Limits the computing time to a few seconds on one core per second of sound.
    void choose_simulation() {
        const auto sources = static_cast<double>(source_points_.size());
        if (random_.chance(0.6))
            simulation_["estimator"] =
                random_.pick<const char*>({"pt", "dpc-published", "dpc", "patch", "patch"});
        if (random_.chance(0.8)) {
            ir_s_ = random_.log_uniform(0.05, 6);
            simulation_["ir_length_s"] = ir_s_;
        }
        // Filter updates, in samples per second of sound.
        const double filter_samples = sources * field_channels_ * ir_s_ * case_.sample_rate_hz;
        constexpr double kMaxSamples = 1.5e8;
        frame_rate_hz_ =
            std::max(5.0, std::min(random_.log_uniform(5, 100), kMaxSamples / filter_samples));
        if (random_.chance(0.9))
            simulation_["frame_rate_hz"] = frame_rate_hz_;
        else
            frame_rate_hz_ = 30;
        // Path segments per second of sound for lossless walls.
        const double mean_free_path_m = 2 / (1 / size_[0] + 1 / size_[1] + 1 / size_[2]);
        const double segments = 1 + ir_s_ * 343 / mean_free_path_m;
        constexpr double kMaxSegments = 1.2e7;
        const double max_rays = kMaxSegments / (sources * frame_rate_hz_ * segments);
        simulation_["rays"] =
            std::max(1L, std::lround(std::min(random_.log_uniform(1, 2000), max_rays)));
        if (random_.chance(0.3)) simulation_["order"] = random_.integer(0, 60);
        if (random_.chance(0.5)) simulation_["specular_order"] = random_.integer(0, 6);
        if (random_.chance(0.5))
            simulation_["response_time_s"] = random_.chance(0.1) ? 0 : random_.log_uniform(0.01, 5);
        if (random_.chance(0.5)) simulation_["patch_size_m"] = random_.log_uniform(0.15, 4);
        if (random_.chance(0.3)) simulation_["listener_radius_m"] = random_.log_uniform(0.05, 2);
        if (random_.chance(0.5)) simulation_["seed"] = random_.integer(0, 1 << 30);
        simulation_["threads"] = random_.integer(1, 3);
        if (random_.chance(0.5)) simulation_["memory_mb"] = random_.integer(1, 256);
        direct_ = !random_.chance(0.1);
        if (!direct_) scene_["simulation"]["direct"] = false;
        if (random_.chance(0.1)) scene_["simulation"]["specular"] = false;
        if (random_.chance(0.3)) scene_["simulation"]["diffraction_order"] = random_.integer(0, 4);
    }

    void choose_mode() {
        constexpr double kSlowest_m_s = 325;  // at -10 °C
        const double arrival_s = farthest_m_ / kSlowest_m_s;
        const int mode = random_.integer(0, 9);
        const bool rendered = mode < 5;
        const bool measured = !rendered && mode < 8;
        // HRTF, patches and the first frame.
        case_.cpu_limit_s = 20;
        if (measured) {
            measure();
        } else {
            case_.duration_s = random_.log_uniform(0.1, 1.2);
            case_.cpu_limit_s += 30 * case_.duration_s;
            if (rendered) {
                option("--offline", (folder_ / "out.wav").string());
                if (random_.chance(0.5))
                    option("--format", random_.pick<const char*>({"float", "pcm24", "pcm16"}));
            } else {
                option("--device", "none");
                case_.command.emplace_back("--no-window");
            }
            const bool short_signals = longest_unlooped_s_ > 0 && longest_unlooped_s_ < 0.6;
            if (rendered && !moves_ && short_signals && ir_s_ < 1 && random_.chance(0.6)) {
                case_.duration_given = false;
                case_.duration_s = longest_unlooped_s_;
                // The margin exceeds the length that the filters add.
                case_.longest_s = longest_unlooped_s_ + std::max(ir_s_, arrival_s) + 0.2;
                case_.cpu_limit_s = 20 + 30 * case_.longest_s;
            } else {
                std::ostringstream text;
                text << case_.duration_s;
                case_.duration_s = std::stod(text.str());
                option("--duration", text.str());
            }
        }
        // Rooms are convex around the positions: without screens the direct sound arrives.
        bool plays = measured;
        for (const Json& source : scene_["sources"]) plays |= source["signal"] == "noise";
        case_.must_be_heard =
            direct_ && plays && screens_ == 0 && (measured || arrival_s < case_.duration_s / 2);
    }

    void measure() {
        const int what = random_.integer(1, 7);
        option("--frames", std::to_string(random_.integer(1, 8)));
        if ((what & 1) != 0) option("--ir", (folder_ / "ir.wav").string());
        if ((what & 2) != 0) {
            option("--echogram", (folder_ / "echogram.csv").string());
            if (random_.chance(0.5))
                option("--bin-ms", std::to_string(random_.log_uniform(0.2, 100)));
        }
        if ((what & 4) != 0)
            case_.command.push_back("--report=" + (folder_ / "report.json").string());
        case_.cpu_limit_s += 30;
    }

    RandomValues random_;
    RandomValues
        directivities_;  ///< apart, so that the other content of a case does not depend on it
    std::filesystem::path folder_;
    MatrixCase case_;
    Json scene_;
    Json simulation_;
    Point size_{};
    Point least_{};
    std::vector<std::vector<Point>> source_points_;
    int materials_ = 0;
    int screens_ = 0;
    int sounds_ = 0;
    int field_channels_ = 4;
    double sound_s_ = 0;
    double longest_unlooped_s_ = 0;
    bool moves_ = false;
    double ir_s_ = 4;
    double farthest_m_ = 0;
    double frame_rate_hz_ = 30;
    bool direct_ = true;
};

}  // namespace

MatrixCase make_case(std::uint64_t seed, const std::filesystem::path& folder) {
    return CaseMaker(seed, folder).make();
}

}  // namespace aula::test
