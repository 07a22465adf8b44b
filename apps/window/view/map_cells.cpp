#include "apps/window/view/map_cells.h"

#include <algorithm>
#include <glm/common.hpp>
#include <utility>

namespace aula {

MapCells::MapCells(const ReceiverGrid& grid, const Measurement& measurement, const Bounds& bounds,
                   const MapChoice& choice)
    : height_m_(grid.height_m) {
    const float half = grid.spacing_m / 2;
    std::vector<std::optional<double>> values;
    for (std::size_t r = 0; r < grid.receivers.size(); ++r) {
        const PairParameters& parameters =
            measurement.parameters[measurement.pair(choice.source, r)];
        const bool octave = choice.band && choice.parameter != kSpeechTransmission;
        values.push_back((octave ? parameters.octaves[choice.parameter][*choice.band]
                                 : single_number(parameters, choice.parameter))
                             .value);
        const glm::vec2 centre(grid.receivers[r].position);
        cells_.push_back({glm::max(centre - half, glm::vec2(bounds.min)),
                          glm::min(centre + half, glm::vec2(bounds.max)), values.back()});
    }
    scale_ = value_scale(values, parameter_text(choice.parameter));
}

MapCells::MapCells(std::vector<Cell> cells, const ValueScale& scale, float height_m)
    : cells_(std::move(cells)), scale_(scale), height_m_(height_m) {}

Colour MapCells::colour(const Cell& cell) const {
    return cell.value ? scale_.colour(*cell.value) : kNoValueColour;
}

const MapCells::Cell* MapCells::at(glm::vec2 point) const {
    const auto cell = std::find_if(cells_.begin(), cells_.end(), [&](const Cell& c) {
        return point.x >= c.low.x && point.y >= c.low.y && point.x < c.high.x && point.y < c.high.y;
    });
    return cell == cells_.end() ? nullptr : &*cell;
}

}  // namespace aula
