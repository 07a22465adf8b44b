#include "engine/waves/wave_grid.h"

namespace aula {

double WaveGrid::total_volume_m3() const {
    double sum = 0;
    for (const float v : volume_m3) sum += double{v};
    return sum;
}

double WaveGrid::wall_m2() const {
    double sum = 0;
    for (const WallPiece& piece : walls) sum += double{piece.area_m2};
    return sum;
}

}  // namespace aula
