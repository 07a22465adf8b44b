// Convolves a block with an impulse: use_audio
#include <aula/audio/convolver.h>

#include <array>
#include <cstdio>
#include <vector>

int main() {
    const aula::ConvolutionShape shape{.block = 64, .taps = 4800};
    aula::FilterTransform transform(shape);
    aula::ConvolutionFilter filter(shape);
    std::vector<float> taps(4800);
    taps[10] = 0.5F;
    const std::array<std::span<const float>, 1> responses{taps};
    transform.transform(responses, 0, filter);
    aula::Convolver convolver(shape, 64);
    convolver.exchange(&filter);
    std::array<float, 64> input{1};
    std::array<float, 64> output{};
    const std::array<const float*, 1> inputs{input.data()};
    const std::array<float*, 1> outputs{output.data()};
    convolver.process(inputs, outputs, 64);
    std::printf("sample 10 is %.3f\n", static_cast<double>(output[10]));
    return output[10] > 0.499F && output[10] < 0.501F ? 0 : 1;
}
