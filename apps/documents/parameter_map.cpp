#include "apps/documents/parameter_map.h"

#include <algorithm>
#include <cmath>

#include "apps/documents/parameter_text.h"
#include "apps/documents/raster_image.h"
#include "apps/output/formatted.h"
#include "apps/room/offline/measurement_text.h"

namespace aula {

namespace {

constexpr Colour kInk{0.13F, 0.14F, 0.16F};
constexpr Colour kFaint{0.55F, 0.57F, 0.60F};
constexpr Colour kWhite{1, 1, 1};
constexpr Colour kSource{0.10F, 0.55F, 0.95F};

// Pixels.
constexpr float kTitleHeight = 26;
constexpr float kTextHeight = 18;
constexpr float kLeft = 70;      ///< of the plan
constexpr float kTop = 84;       ///< of the plan
constexpr float kRight = 150;    ///< room for the scale beside the plan
constexpr float kBottom = 70;    ///< room for the axis below the plan
constexpr float kLongest = 960;  ///< of the plan's sides
constexpr float kLeastWidth = 420;
constexpr float kLeastHeight = 240;

const MeasuredValue& value_at(const ParameterMap& map, std::size_t source, std::size_t receiver,
                              std::size_t parameter) {
    return single_number(map.measurement.parameters[map.measurement.pair(source, receiver)],
                         parameter);
}

std::string csv_number(const std::optional<double>& value) {
    return value ? formatted(",%.6g", *value) : ",";
}

/// The columns of the value or of the standard error of a parameter.
std::string csv_columns(const PairParameters& parameters, std::size_t parameter, bool in_thirds,
                        std::optional<double> MeasuredValue::*part) {
    std::string text = csv_number(single_number(parameters, parameter).*part);
    if (parameter == kSpeechTransmission) return text;
    if (in_thirds) {
        // None of a source that is not audible.
        static const std::array<MeasuredValue, kThirdOctaveCount> kNone{};
        for (const MeasuredValue& third :
             parameters.third_octaves.empty() ? kNone : parameters.third_octaves[parameter])
            text += csv_number(third.*part);
    } else {
        for (const MeasuredValue& octave : parameters.octaves[parameter])
            text += csv_number(octave.*part);
    }
    return text;
}

/// Draws maps: the area of the plan, and what is inside of it and beside it.
class MapPicture {
 public:
    MapPicture(const ParameterMap& map, std::size_t source, std::size_t parameter)
        : map_(map),
          source_(source),
          parameter_(parameter),
          text_(parameter_text(parameter)),
          size_m_(glm::max(map.plan.max - map.plan.min, glm::vec2(1e-3F))),
          pixels_per_m_(kLongest / std::max(size_m_.x, size_m_.y)),
          plan_(size_m_ * pixels_per_m_),
          area_(glm::max(plan_, glm::vec2(kLeastWidth, kLeastHeight))),
          corner_(glm::vec2(kLeft, kTop) + (area_ - plan_) / 2.0F),
          image_(static_cast<int>(kLeft + area_.x + kRight),
                 static_cast<int>(kTop + area_.y + kBottom), kFontFolder / "DejaVuSans.ttf") {}

    std::string draw(const std::string& scene) {
        std::vector<std::optional<double>> values;
        for (std::size_t r = 0; r < map_.grid.receivers.size(); ++r)
            values.push_back(value_at(map_, source_, r, parameter_).value);
        scale_ = value_scale(values, text_);
        draw_titles(scene);
        draw_cells(values);
        // Dark lines with a light margin, for cells of any colour.
        for (const auto& [from, to] : map_.plan.walls)
            image_.line(pixel(from), pixel(to), 4, kWhite);
        for (const auto& [from, to] : map_.plan.walls) image_.line(pixel(from), pixel(to), 2, kInk);
        draw_axes();
        draw_sources();
        draw_scale(std::any_of(values.begin(), values.end(),
                               [](const auto& value) { return !value.has_value(); }));
        return image_.png();
    }

 private:
    glm::vec2 pixel(glm::vec2 m) const {
        const glm::vec2 from_corner = (m - map_.plan.min) * pixels_per_m_;
        return corner_ + glm::vec2(from_corner.x, plan_.y - from_corner.y);
    }

    void draw_titles(const std::string& scene) {
        std::string title = text_.name;
        title[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(title[0])));
        if (!text_.unit.empty()) title += " in " + text_.unit;
        image_.text({kLeft, 34}, fitting(title, kTitleHeight), kTitleHeight, kInk);
        image_.text({kLeft, 60},
                    fitting(text_.single + ", source " + map_.measurement.sources[source_].name +
                                ", " + scene + ", " + map_.grid.place,
                            kTextHeight),
                    kTextHeight, kInk);
    }

    /// The text, smaller if it is wider than the picture: truncated with "...".
    std::string fitting(std::string text, float height) const {
        const float width = static_cast<float>(image_.width()) - kLeft - 10;
        if (image_.text_width(text, height) <= width) return text;
        do {
            // Whole characters of UTF-8.
            while (!text.empty() && (static_cast<unsigned char>(text.back()) >> 6) == 2)
                text.pop_back();
            if (!text.empty()) text.pop_back();
        } while (!text.empty() && image_.text_width(text + "...", height) > width);
        return text + "...";
    }

    void draw_cells(const std::vector<std::optional<double>>& values) {
        const float half = map_.grid.spacing_m / 2;
        for (std::size_t r = 0; r < values.size(); ++r) {
            const glm::vec2 centre(map_.grid.receivers[r].position);
            const glm::vec2 low = glm::max(centre - half, map_.plan.min);
            const glm::vec2 high = glm::min(centre + half, map_.plan.max);
            image_.fill(pixel({low.x, high.y}), pixel({high.x, low.y}),
                        values[r] ? scale_.colour(*values[r]) : kNoValueColour);
        }
    }

    void draw_axes() {
        const glm::vec2 low = corner_ + glm::vec2(0, plan_.y);
        const float y = low.y + 10;
        const float x = corner_.x - 10;
        image_.line({corner_.x, y}, {corner_.x + plan_.x, y}, 1, kFaint);
        image_.line({x, corner_.y}, {x, low.y}, 1, kFaint);
        const auto marks = [&](float from, float to) {
            const float length = (to - from) * pixels_per_m_;
            return round_numbers(double{from}, double{to},
                                 std::max(1, static_cast<int>(length / 80)));
        };
        const std::vector<double> along_x = marks(map_.plan.min.x, map_.plan.max.x);
        for (const double at : along_x) {
            const float mark = pixel({static_cast<float>(at), 0}).x;
            image_.line({mark, y}, {mark, y + 6}, 1, kFaint);
            const std::string label = fixed_text(at, decimals_of(along_x));
            image_.text({mark - image_.text_width(label, kTextHeight) / 2, y + 24}, label,
                        kTextHeight, kInk);
        }
        const std::string unit = "x in m";
        image_.text({corner_.x + (plan_.x - image_.text_width(unit, kTextHeight)) / 2, y + 46},
                    unit, kTextHeight, kInk);
        const std::vector<double> along_y = marks(map_.plan.min.y, map_.plan.max.y);
        for (const double at : along_y) {
            const float mark = pixel({0, static_cast<float>(at)}).y;
            image_.line({x - 6, mark}, {x, mark}, 1, kFaint);
            const std::string label = fixed_text(at, decimals_of(along_y));
            image_.text({x - 10 - image_.text_width(label, kTextHeight), mark + 6}, label,
                        kTextHeight, kInk);
        }
        image_.text({x - 50, corner_.y - 18}, "y in m", kTextHeight, kInk);
    }

    /// All sources as dots, with names; that of the map is larger.
    void draw_sources() {
        for (std::size_t s = 0; s < map_.measurement.sources.size(); ++s) {
            const Source& source = map_.measurement.sources[s];
            const glm::vec2 at = pixel(glm::vec2(source.position_at(0)));
            const float radius = s == source_ ? 8 : 5;
            image_.disc(at, radius + 2, kWhite);
            image_.disc(at, radius, s == source_ ? kSource : kFaint);
            const float width = image_.text_width(source.name, kTextHeight);
            glm::vec2 label = at + glm::vec2(radius + 6, 6);
            const float end = static_cast<float>(image_.width()) - kRight;
            if (label.x + width > end) label.x = at.x - radius - 6 - width;
            image_.fill(label + glm::vec2(-3, -kTextHeight + 3), label + glm::vec2(width + 3, 5),
                        kWhite);
            image_.text(label, source.name, kTextHeight, kInk);
        }
    }

    void draw_scale(bool with_missing) {
        constexpr float kWidth = 24;
        const float x = kLeft + area_.x + 30;
        const float top = kTop + 10;
        const float height = area_.y - (with_missing ? 50 : 10);
        for (int row = 0; row < static_cast<int>(height); ++row) {
            const float share = 1 - (static_cast<float>(row) + 0.5F) / height;
            image_.fill({x, top + static_cast<float>(row)},
                        {x + kWidth, top + static_cast<float>(row) + 1}, map_colour(share));
        }
        const std::vector<double> marks =
            round_numbers(scale_.min, scale_.max, static_cast<int>(height / 60));
        for (const double mark : marks) {
            const auto share = static_cast<float>((mark - scale_.min) / (scale_.max - scale_.min));
            const float y = top + (1 - share) * height;
            image_.line({x + kWidth, y}, {x + kWidth + 6, y}, 1, kInk);
            image_.text({x + kWidth + 10, y + 6}, fixed_text(mark, decimals_of(marks)), kTextHeight,
                        kInk);
        }
        const std::string unit =
            text_.unit.empty() ? text_.symbol : text_.symbol + " in " + text_.unit;
        image_.text({x, top - 12}, unit, kTextHeight, kInk);
        if (!with_missing) return;
        image_.fill({x, top + height + 20}, {x + kWidth, top + height + 36}, kNoValueColour);
        image_.text({x + kWidth + 10, top + height + 34}, "no value", kTextHeight, kInk);
    }

    const ParameterMap& map_;
    std::size_t source_;
    std::size_t parameter_;
    ParameterText text_;
    glm::vec2 size_m_;
    float pixels_per_m_;
    glm::vec2 plan_;    ///< size of the plan, pixels
    glm::vec2 area_;    ///< size of the area that contains it
    glm::vec2 corner_;  ///< upper left corner of the plan
    ValueScale scale_;
    RasterImage image_;
};

}  // namespace

std::string map_csv(const ParameterMap& map, std::size_t source, std::size_t parameter) {
    std::string csv = "x_m,y_m,z_m";
    const auto& all = map.measurement.parameters;
    const bool in_thirds = std::any_of(all.begin(), all.end(), [&](const PairParameters& pair) {
        return parameter < pair.third_octaves.size();
    });
    for (const char* const suffix : {"", "_error"}) {
        csv += std::string(",value") + suffix;
        if (parameter == kSpeechTransmission) continue;
        for (std::size_t band = 0; band < (in_thirds ? kThirdOctaveCount : kBandCount); ++band)
            csv += ',' + (in_thirds ? third_octave_name(band) : band_name(band)) + suffix;
    }
    csv += '\n';
    for (std::size_t r = 0; r < map.grid.receivers.size(); ++r) {
        const Vec3& p = map.grid.receivers[r].position;
        const PairParameters& parameters =
            map.measurement.parameters[map.measurement.pair(source, r)];
        csv += formatted("%.6g,%.6g,%.6g", double{p.x}, double{p.y}, double{p.z}) +
               csv_columns(parameters, parameter, in_thirds, &MeasuredValue::value) +
               csv_columns(parameters, parameter, in_thirds, &MeasuredValue::standard_error) + '\n';
    }
    return csv;
}

std::string map_png(const ParameterMap& map, std::size_t source, std::size_t parameter,
                    const std::string& scene) {
    return MapPicture(map, source, parameter).draw(scene);
}

}  // namespace aula
