#include "audio/convolver.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <utility>

#include "audio/kernels.h"

namespace aula {

namespace {

constexpr std::size_t round_up(std::size_t n, std::size_t multiple) {
    return (n + multiple - 1) / multiple * multiple;
}

void split(const std::complex<float>* in, std::size_t count, std::size_t padded, float scale,
           float* out) noexcept {
    for (std::size_t k = 0; k < count; ++k) {
        out[k] = scale * in[k].real();
        out[padded + k] = scale * in[k].imag();
    }
}

void join(const float* in, std::size_t count, std::size_t padded,
          std::complex<float>* out) noexcept {
    for (std::size_t k = 0; k < count; ++k) out[k] = {in[k], in[padded + k]};
}

}  // namespace

std::size_t ConvolutionShape::partition() const { return fast_fft_size(2 * block) / 2; }

std::size_t ConvolutionShape::partition_count() const {
    return std::max<std::size_t>(1, round_up(taps, partition()) / partition());
}

std::size_t ConvolutionShape::padded_bins() const {
    return round_up(partition() + 1, kBinMultiple);
}

ConvolutionFilter::ConvolutionFilter(const ConvolutionShape& shape)
    : partitions_(shape.partition_count()),
      outputs_(shape.outputs),
      stride_(2 * shape.padded_bins()),
      counts_(shape.inputs),
      spectra_(shape.inputs * partitions_ * outputs_ * stride_) {}

FilterTransform::FilterTransform(const ConvolutionShape& shape)
    : shape_(shape),
      fft_(2 * shape.partition()),
      signal_(2 * shape.partition()),
      spectrum_(fft_.bins()) {}

void FilterTransform::transform(std::span<const std::span<const float>> responses,
                                std::size_t input, ConvolutionFilter& filter) {
    assert(responses.size() == shape_.outputs && input < shape_.inputs);
    const std::size_t size = shape_.partition();
    std::size_t longest = 0;
    for (const std::span<const float> response : responses) {
        std::size_t taps = response.size();
        while (taps > 0 && response[taps - 1] == 0) --taps;
        longest = std::max(longest, taps);
    }
    assert(longest <= shape_.taps);
    const std::size_t count = round_up(longest, size) / size;
    filter.counts_[input] = count;
    const float scale = 1 / static_cast<float>(fft_.size());
    for (std::size_t p = 0; p < count; ++p) {
        for (std::size_t o = 0; o < shape_.outputs; ++o) {
            const std::size_t first = std::min(p * size, responses[o].size());
            const std::size_t last = std::min(first + size, responses[o].size());
            const auto end =
                std::copy(responses[o].data() + first, responses[o].data() + last, signal_.begin());
            std::fill(end, signal_.end(), 0.0F);
            fft_.forward(signal_.data(), spectrum_.data());
            split(spectrum_.data(), fft_.bins(), shape_.padded_bins(), scale,
                  filter.spectra_.data() + filter.offset(input, p, o));
        }
    }
}

Convolver::Convolver(const ConvolutionShape& shape, std::size_t fade_samples)
    : shape_(shape),
      partition_(shape.partition()),
      partitions_(shape.partition_count()),
      stride_(2 * shape.padded_bins()),
      fft_(2 * partition_),
      windows_(shape.inputs * 2 * partition_),
      spectra_(shape.inputs * partitions_ * stride_),
      fade_(raised_cosine(fade_samples)),
      sum_(stride_),
      interleaved_(fft_.bins()),
      signal_(2 * partition_) {
    current_.tail.resize(shape.outputs * stride_);
    next_.tail.resize(shape.outputs * stride_);
}

void Convolver::exchange(const ConvolutionFilter* filter) noexcept {
    assert(filter != nullptr && !fading());
    Voice& voice = current_.filter == nullptr ? current_ : next_;
    voice.filter = filter;
    voice.tail_ready = false;
    fade_position_ = 0;
}

void Convolver::process(std::span<const float* const> inputs, std::span<float* const> outputs,
                        std::size_t samples) noexcept {
    assert(inputs.size() == shape_.inputs && outputs.size() == shape_.outputs);
    assert(samples <= shape_.block);
    for (std::size_t done = 0; done < samples;) {
        const std::size_t part = std::min(samples - done, partition_ - filled_);
        process_part(inputs, outputs, done, part);
        done += part;
    }
    if (fading() && fade_position_ >= fade_.size()) {
        std::swap(current_, next_);
        next_.filter = nullptr;
    }
}

// The partition in hand is transformed with zeros in place of its samples to come: the outputs up
// to the newest sample do not depend on them.
void Convolver::process_part(std::span<const float* const> inputs, std::span<float* const> outputs,
                             std::size_t offset, std::size_t samples) noexcept {
    for (std::size_t i = 0; i < shape_.inputs; ++i) {
        float* const window = windows_.data() + i * 2 * partition_;
        std::copy_n(inputs[i] + offset, samples, window + partition_ + filled_);
        fft_.forward(window, interleaved_.data());
        split(interleaved_.data(), fft_.bins(), stride_ / 2, 1, input_spectrum(i, 0));
    }
    if (current_.filter != nullptr) prepare_tail(current_);
    if (next_.filter != nullptr) prepare_tail(next_);

    for (std::size_t o = 0; o < shape_.outputs; ++o) {
        float* const out = outputs[o] + offset;
        if (current_.filter == nullptr) {
            std::fill_n(out, samples, 0.0F);
            continue;
        }
        std::copy_n(voice_output(current_, o) + filled_, samples, out);
        if (next_.filter == nullptr) continue;
        const float* const faded_in = voice_output(next_, o) + filled_;
        for (std::size_t n = 0; n < samples; ++n) {
            const std::size_t position = fade_position_ + n;
            const float weight = position < fade_.size() ? fade_[position] : 1.0F;
            out[n] += weight * (faded_in[n] - out[n]);
        }
    }
    if (next_.filter != nullptr) fade_position_ += samples;

    filled_ += samples;
    if (filled_ < partition_) return;
    filled_ = 0;
    newest_ = newest_ + 1 == partitions_ ? 0 : newest_ + 1;
    current_.tail_ready = next_.tail_ready = false;
    for (std::size_t i = 0; i < shape_.inputs; ++i) {
        float* const window = windows_.data() + i * 2 * partition_;
        std::copy_n(window + partition_, partition_, window);
        std::fill_n(window + partition_, partition_, 0.0F);
    }
}

void Convolver::prepare_tail(Voice& voice) noexcept {
    if (voice.tail_ready) return;
    voice.tail_ready = true;
    std::fill(voice.tail.begin(), voice.tail.end(), 0.0F);
    for (std::size_t i = 0; i < shape_.inputs; ++i) {
        for (std::size_t p = 1; p < voice.filter->partition_count(i); ++p) {
            for (std::size_t o = 0; o < shape_.outputs; ++o) {
                multiply_add_spectra(input_spectrum(i, p), voice.filter->spectrum(i, p, o),
                                     voice.tail.data() + o * stride_, stride_ / 2);
            }
        }
    }
}

/// One output of the partition in hand, partition() samples.
const float* Convolver::voice_output(const Voice& voice, std::size_t output) noexcept {
    std::copy_n(voice.tail.data() + output * stride_, stride_, sum_.data());
    for (std::size_t i = 0; i < shape_.inputs; ++i) {
        if (voice.filter->partition_count(i) == 0) continue;
        multiply_add_spectra(input_spectrum(i, 0), voice.filter->spectrum(i, 0, output),
                             sum_.data(), stride_ / 2);
    }
    join(sum_.data(), fft_.bins(), stride_ / 2, interleaved_.data());
    fft_.inverse(interleaved_.data(), signal_.data());
    return signal_.data() + partition_;
}

/// The input's spectrum of `age` partitions ago.
float* Convolver::input_spectrum(std::size_t input, std::size_t age) noexcept {
    const std::size_t place = (newest_ + partitions_ - age) % partitions_;
    return spectra_.data() + (input * partitions_ + place) * stride_;
}

// w[n] = (1 - cos(pi (n + 1/2) / N)) / 2: symmetric, so that w[n] + w[N - 1 - n] = 1.
std::vector<float> raised_cosine(std::size_t samples) {
    std::vector<float> weights(samples);
    for (std::size_t n = 0; n < samples; ++n) {
        weights[n] = static_cast<float>(
            0.5 - 0.5 * std::cos(std::numbers::pi * (static_cast<double>(n) + 0.5) /
                                 static_cast<double>(samples)));
    }
    return weights;
}

}  // namespace aula
