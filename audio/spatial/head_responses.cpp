#include "audio/spatial/head_responses.h"

#include <cstddef>

#include "audio/dsp/fade.h"

namespace aula {

double HeadResponses::centre_delay_s() const {
    double sum = 0;
    for (std::size_t i = 0; i < ears.size(); ++i) {
        sum += weights[i] * 0.5 * (ears[i][0].delay_s + ears[i][1].delay_s);
    }
    return sum;
}

void fade_out(std::span<float> response) {
    Fade fade(response.size() / 4);
    fade.start();
    fade.fade_out(response.last(response.size() / 4));
}

}  // namespace aula
