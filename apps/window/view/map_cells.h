#pragma once

#include <glm/vec2.hpp>
#include <optional>
#include <vector>

#include "apps/documents/receiver_grid.h"
#include "apps/documents/value_scale.h"
#include "aula/measurement.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// What a map shows.
struct MapChoice {
    std::size_t source = 0;
    std::size_t parameter = static_cast<std::size_t>(AcousticParameter::t30);
    std::optional<std::size_t> band;  ///< empty: the single number; not used for STI
    friend bool operator==(const MapChoice&, const MapChoice&) = default;
};

/// The cells of a map with their values, as the window draws them.
class MapCells {
 public:
    /// `bounds` of the geometry limit the cells.
    MapCells(const ReceiverGrid& grid, const Measurement& measurement, const Bounds& bounds,
             const MapChoice& choice);

    struct Cell;
    /// Of any values in a horizontal plane.
    MapCells(std::vector<Cell> cells, const ValueScale& scale, float height_m);

    /// A cell of the map in the plane of the receivers.
    struct Cell {
        glm::vec2 low{0};
        glm::vec2 high{0};
        std::optional<double> value;
    };
    const std::vector<Cell>& cells() const { return cells_; }
    float height_m() const { return height_m_; }

    /// The scale of the colours: that of the picture that `aula map` writes.
    const ValueScale& scale() const { return scale_; }
    Colour colour(const Cell& cell) const;

    /// The cell that contains a point; null: none.
    const Cell* at(glm::vec2 point) const;

 private:
    std::vector<Cell> cells_;
    ValueScale scale_;
    float height_m_;
};

}  // namespace aula
