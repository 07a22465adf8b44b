#include "audio/render/headphones.h"

#include <algorithm>
#include <cassert>

#include "aula/audio/convolver.h"

namespace aula {

class HeadphoneEqualizer::Ear {
 public:
    Ear(std::span<const float> response, std::size_t block)
        : shape_{.block = block, .taps = response.size()},
          filter_(shape_),
          convolver_(shape_, 0),
          input_(block) {
        FilterTransform transform(shape_);
        transform.transform({&response, 1}, 0, filter_);
        convolver_.exchange(&filter_);
    }

    void process(float* ear, std::size_t samples) noexcept AULA_NONBLOCKING {
        assert(samples <= input_.size());
        std::copy_n(ear, samples, input_.data());
        const float* const input = input_.data();
        convolver_.process({&input, 1}, {&ear, 1}, samples);
    }

 private:
    ConvolutionShape shape_;
    ConvolutionFilter filter_;
    Convolver convolver_;
    std::vector<float> input_;
};

HeadphoneEqualizer::HeadphoneEqualizer(const HeadphoneFilter& filter, int block) {
    for (const std::vector<float>& ear : filter.ears)
        ears_.push_back(std::make_unique<Ear>(ear, static_cast<std::size_t>(block)));
}

HeadphoneEqualizer::~HeadphoneEqualizer() = default;
HeadphoneEqualizer::HeadphoneEqualizer(HeadphoneEqualizer&&) noexcept = default;
HeadphoneEqualizer& HeadphoneEqualizer::operator=(HeadphoneEqualizer&&) noexcept = default;

void HeadphoneEqualizer::process(std::span<float* const> ears, int samples) noexcept {
    assert(ears.size() == ears_.size());
    for (std::size_t e = 0; e < ears.size(); ++e)
        ears_[e]->process(ears[e], static_cast<std::size_t>(samples));
}

void equalize(const HeadphoneFilter& filter, std::vector<std::vector<float>>& response) {
    constexpr int kBlock = 256;
    const FlushDenormals flush;
    HeadphoneEqualizer equalizer(filter, kBlock);
    const std::size_t length = response[0].size() + filter.taps() - 1;
    for (std::vector<float>& ear : response) ear.resize(length);
    for (std::size_t first = 0; first < length; first += kBlock) {
        const std::array<float*, 2> ears{response[0].data() + first, response[1].data() + first};
        equalizer.process(ears, static_cast<int>(std::min<std::size_t>(kBlock, length - first)));
    }
}

}  // namespace aula
