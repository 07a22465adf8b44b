#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>

#include "apps/documents/receiver_grid.h"
#include "apps/drawing/room_section.h"
#include "aula/measurement.h"

namespace aula {

/// The parameters of maps, by their index in parameter_text(): all but those of IACC, which need
/// binaural impulse responses, and all.
inline constexpr std::array<std::size_t, 12> kMappedParameters{0, 1, 2, 3, 4,  5,
                                                               6, 7, 8, 9, 10, 13};
inline constexpr std::array<std::size_t, 14> kAllParameters{0, 1, 2, 3,  4,  5,  6,
                                                            7, 8, 9, 10, 11, 12, 13};

/// The parameters of maps with or without IACC.
inline std::span<const std::size_t> mapped_parameters(bool interaural) {
    return interaural ? std::span<const std::size_t>(kAllParameters) : kMappedParameters;
}

/// A map of a room: what its measurements were made of.
struct ParameterMap {
    const ReceiverGrid& grid;
    const RoomSection& plan;         ///< at the height of the grid
    const Measurement& measurement;  ///< at the receivers of the grid
};

/// A parameter of a source as CSV, with the header "x_m,y_m,z_m,value,63,..,8000,value_error,
/// 63_error,..,8000_error": one row for each receiver. `value` is the single number; errors are
/// standard errors. If the measurement has third octaves, T20 to G have columns from 50 to 16000 in
/// place of octaves. The speech transmission index has no columns of octaves. What is not known is
/// empty.
std::string map_csv(const ParameterMap& map, std::size_t source, std::size_t parameter);

/// The single numbers as a picture of cells with a plan of the room and a scale, as a PNG file.
/// Cells without a value are grey. `scene` is the name of the scene.
std::string map_png(const ParameterMap& map, std::size_t source, std::size_t parameter,
                    const std::string& scene);

}  // namespace aula
