#include "audio/convolution/convolver_levels.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace aula {

namespace {

/// Chunks whose products are summed in one piece, for one output or shared by more.
constexpr std::size_t kChunksOfPiece = 8;

std::size_t chunks_of_piece(std::size_t outputs) {
    return std::max<std::size_t>(1, kChunksOfPiece / outputs);
}

/// Products of a chunk that are summed in one piece.
constexpr std::size_t kProductsOfPiece = 16;

std::size_t slices_of(std::size_t products) {
    return (products + kProductsOfPiece - 1) / kProductsOfPiece;
}

// Sizes at least double from level to level: that of level l > 0 is a multiple of 2^l partitions of
// the head. Its frames start 2^(l - 1) partitions of the head before multiples of its size, where
// no other level's do.
std::size_t lead_samples(const ConvolutionShape& shape, std::size_t index) {
    return partition_levels(shape)[0].size << (index - 1);
}

}  // namespace

SpectralHistory::SpectralHistory(std::size_t inputs, const PartitionLevel& level)
    : ages_(level.count), size_(level.size), spectra_(inputs * ages_ * 2 * size_) {}

LevelSums::LevelSums(const ConvolutionShape& shape, const PartitionLevel& level, std::size_t index)
    : inputs_(shape.inputs),
      outputs_(shape.outputs),
      index_(index),
      multiply_add_(level.half_precision ? best_kernels().multiply_add_half
                                         : best_kernels().multiply_add) {
    for (Terms* const terms : {&shared_, &current_only_, &next_only_}) {
        terms->terms.resize(inputs_ * level.count);
    }
}

void LevelSums::collect(SpectralHistory& history, const ConvolutionFilter* current,
                        const ConvolutionFilter* next, std::size_t first,
                        std::size_t last) noexcept {
    shared_.count = current_only_.count = next_only_.count = 0;
    constexpr FilterPartition kSilence;
    for (std::size_t i = 0; i < inputs_; ++i) {
        const FilterPartition* const olds = current ? current->partitions(index_, i) : nullptr;
        const FilterPartition* const youngs = next ? next->partitions(index_, i) : nullptr;
        for (std::size_t p = first; p < last; ++p) {
            const FilterPartition& old = olds ? olds[p] : kSilence;
            const FilterPartition& young = youngs ? youngs[p] : kSilence;
            const auto list = [&](Terms& to, const FilterPartition& added) {
                if (added.spectra == nullptr) return;
                to.terms[to.count++] = {history.spectrum(i, p), added.spectra, added.scale};
            };
            if (old.spectra == young.spectra) {
                list(shared_, old);
            } else {
                list(current_only_, old);
                list(next_only_, young);
            }
        }
    }
}

void LevelSums::multiply_add(const Terms& terms, std::size_t first_chunk, std::size_t last_chunk,
                             float* sums) const noexcept {
    multiply_add_({terms.terms.data(), terms.count}, outputs_, first_chunk, last_chunk, sums);
}

std::size_t LevelSums::slices() const noexcept {
    return slices_of(shared_.count) + slices_of(current_only_.count) + slices_of(next_only_.count);
}

SpectralTerms LevelSums::slice(std::size_t index) const noexcept {
    const Terms* terms = nullptr;
    for (const Terms* const candidate : {&shared_, &current_only_, &next_only_}) {
        terms = candidate;
        const std::size_t slices = slices_of(candidate->count);
        if (index < slices) break;
        index -= slices;
    }
    const std::size_t first = index * kProductsOfPiece;
    assert(first < terms->count);
    const std::size_t known = terms->count - first;
    return {terms->terms.data() + first, std::min(kProductsOfPiece, known), known};
}

std::size_t LevelSums::products_of(std::size_t index) const noexcept { return slice(index).count; }

void LevelSums::set_slice(std::size_t index, std::size_t first_chunk, std::size_t last_chunk,
                          float* current, float* next) const noexcept {
    const std::size_t first = first_chunk * outputs_ * kChunk_floats;
    const std::size_t count = (last_chunk - first_chunk) * outputs_ * kChunk_floats;
    if (index == 0) std::fill_n(current + first, count, 0.0F);
    // Both begin with what they share.
    if (differs() && index == slices_of(shared_.count)) {
        std::copy_n(current + first, count, next + first);
    }
    const bool of_next = index >= slices_of(shared_.count) + slices_of(current_only_.count);
    multiply_add_(slice(index), outputs_, first_chunk, last_chunk, of_next ? next : current);
}

void LevelSums::set(std::size_t first_chunk, std::size_t last_chunk, bool with_next, float* current,
                    float* next) const noexcept {
    const std::size_t first = first_chunk * outputs_ * kChunk_floats;
    const std::size_t count = (last_chunk - first_chunk) * outputs_ * kChunk_floats;
    std::fill_n(current + first, count, 0.0F);
    multiply_add(shared_, first_chunk, last_chunk, current);
    if (with_next) std::copy_n(current + first, count, next + first);
    multiply_add(current_only_, first_chunk, last_chunk, current);
    if (with_next) multiply_add(next_only_, first_chunk, last_chunk, next);
}

void LevelSums::add(std::size_t first_chunk, std::size_t last_chunk, bool with_next, float* current,
                    float* next) const noexcept {
    multiply_add(shared_, first_chunk, last_chunk, current);
    multiply_add(current_only_, first_chunk, last_chunk, current);
    if (!with_next) return;
    multiply_add(shared_, first_chunk, last_chunk, next);
    multiply_add(next_only_, first_chunk, last_chunk, next);
}

HeadLevel::HeadLevel(const ConvolutionShape& shape, const PartitionLevel& level,
                     std::size_t fade_samples)
    : inputs_(shape.inputs),
      outputs_(shape.outputs),
      level_(level),
      transform_(level.size),
      history_(shape.inputs, level),
      before_(shape, level, 0),
      now_(shape, level, 0),
      fade_(fade_samples),
      windows_(shape.inputs * 2 * level.size),
      work_(transform_.work_floats()),
      heard_(level.size),
      faded_in_(level.size) {
    for (AlignedVector<float>* const sums : {&tail_, &next_tail_, &sums_, &next_sums_}) {
        sums->resize(2 * level.size * shape.outputs);
    }
}

void HeadLevel::exchange(const ConvolutionFilter* filter) noexcept {
    assert(filter != nullptr && !fading());
    next_ = filter;
    tail_ready_ = false;
    fade_.start();
}

// The partition in hand is transformed with zeros in place of its samples to come: the outputs up
// to the newest sample do not depend on them.
void HeadLevel::process(std::span<const float* const> inputs, std::span<float* const> outputs,
                        std::size_t offset, std::size_t samples) noexcept {
    for (std::size_t i = 0; i < inputs_; ++i) {
        float* const window = windows_.data() + i * 2 * level_.size;
        std::copy_n(inputs[i] + offset, samples, window + level_.size + filled_);
        transform_.forward(window, window + level_.size, work_.data(), history_.spectrum(i, 0));
    }
    const ConvolutionFilter* const next = fading() ? next_ : current_;
    const std::size_t chunks = transform_.chunks();
    if (!tail_ready_) {
        before_.collect(history_, current_, next, 1, level_.count);
        now_.collect(history_, current_, next, 0, 1);
    }
    const bool differs = before_.differs() || now_.differs();
    if (!tail_ready_) before_.set(0, chunks, differs, tail_.data(), next_tail_.data());
    tail_ready_ = true;
    std::copy(tail_.begin(), tail_.end(), sums_.begin());
    if (differs) std::copy(next_tail_.begin(), next_tail_.end(), next_sums_.begin());
    now_.add(0, chunks, differs, sums_.data(), next_sums_.data());

    const std::size_t stride = outputs_ * kChunk_floats;
    for (std::size_t o = 0; o < outputs_; ++o) {
        float* const out = outputs[o] + offset;
        transform_.inverse(sums_.data() + o * kChunk_floats, stride, work_.data(), heard_.data());
        std::copy_n(heard_.data() + filled_, samples, out);
        if (!differs) continue;
        transform_.inverse(next_sums_.data() + o * kChunk_floats, stride, work_.data(),
                           faded_in_.data());
        for (std::size_t n = 0; n < samples; ++n)
            out[n] += fade_.weight(n) * (faded_in_[filled_ + n] - out[n]);
    }
    filled_ += samples;
    if (filled_ == level_.size) finish_partition();
    if (!fading()) return;
    fade_.advance(samples);
    if (!fade_.done()) return;
    current_ = std::exchange(next_, nullptr);
    tail_ready_ = false;
}

void HeadLevel::finish_partition() noexcept {
    filled_ = 0;
    tail_ready_ = false;
    history_.advance();
    for (std::size_t i = 0; i < inputs_; ++i) {
        float* const window = windows_.data() + i * 2 * level_.size;
        std::copy_n(window + level_.size, level_.size, window);
        std::fill_n(window + level_.size, level_.size, 0.0F);
    }
}

TailLevel::TailLevel(const ConvolutionShape& shape, const PartitionLevel& level, std::size_t index)
    : inputs_(shape.inputs),
      outputs_(shape.outputs),
      level_(level),
      transform_(level.size),
      history_(shape.inputs, level),
      sums_(shape, level, index),
      fade_(raised_cosine(level.size)),
      product_cost_(product_cost(shape, level, false)),
      exchanging_cost_(product_cost(shape, level, true)),
      step_cost_(transform_cost(level.size) / static_cast<double>(transform_.steps())),
      position_(lead_samples(shape, index)),
      windows_(3 * shape.inputs * level.size),
      sum_groups_((transform_.chunks() + chunks_of_piece(shape.outputs) - 1) /
                  chunks_of_piece(shape.outputs)),
      // Before the first frame lies silence, whose spectra are there.
      pieces_done_(shape.inputs * transform_.steps()),
      current_sums_(2 * level.size * shape.outputs),
      next_sums_(2 * level.size * shape.outputs),
      work_(transform_.work_floats()) {
    for (Frame* const frame : {&heard_, &computed_}) {
        frame->samples.resize(shape.outputs * level.size);
        frame->faded_in.resize(shape.outputs * level.size);
    }
}

void TailLevel::process(std::span<const float* const> inputs, std::span<float* const> outputs,
                        std::size_t offset, std::size_t samples,
                        const ConvolutionFilter* newest) noexcept {
    assert(position_ + samples <= level_.size);
    if (position_ == 0) start_frame(newest);
    for (std::size_t i = 0; i < inputs_; ++i) {
        std::copy_n(inputs[i] + offset, samples, window(0, i) + position_);
    }
    for (std::size_t o = 0; o < outputs_; ++o) {
        const std::size_t first = o * level_.size + position_;
        const float* const heard = heard_.samples.data() + first;
        const float* const faded_in = heard_.faded_in.data() + first;
        const float* const weights = fade_.data() + position_;
        float* const out = outputs[o] + offset;
        for (std::size_t n = 0; n < samples; ++n) out[n] += heard[n];
        if (!heard_.fades) continue;
        for (std::size_t n = 0; n < samples; ++n) out[n] += weights[n] * (faded_in[n] - heard[n]);
    }
    position_ += samples;
    work_until(cost_of_frame_ * static_cast<double>(position_) / static_cast<double>(level_.size));
    if (position_ == level_.size) finish_frame();
}

void TailLevel::start_frame(const ConvolutionFilter* newest) noexcept {
    history_.advance();
    next_ = newest;
    sums_.collect(history_, current_, next_, 0, level_.count);
    const std::size_t voices = sums_.product_count() == 0 ? 0 : sums_.differs() ? 2 : 1;
    output_pieces_ = outputs_ * voices * transform_.steps();
    sum_pieces_ = sum_groups_ * sums_.slices();
    cost_of_product_ = (sums_.differs() ? exchanging_cost_ : product_cost_) *
                       static_cast<double>(chunks_of_piece(outputs_));
    pieces_done_ = 0;
    cost_done_ = 0;
    const std::size_t steps = inputs_ * transform_.steps() + output_pieces_;
    cost_of_frame_ = step_cost_ * static_cast<double>(steps) +
                     cost_of_product_ * static_cast<double>(sum_groups_ * sums_.product_count());
}

void TailLevel::work_until(double due) noexcept {
    const std::size_t input_pieces = inputs_ * transform_.steps();
    const std::size_t all = input_pieces + sum_pieces_ + output_pieces_;
    // The last pieces are not left undone for a rounding of the cost.
    while (pieces_done_ < all && (cost_done_ < due || position_ == level_.size)) {
        if (pieces_done_ < input_pieces) {
            transform_input(pieces_done_);
            cost_done_ += step_cost_;
        } else if (pieces_done_ < input_pieces + sum_pieces_) {
            sum_products(pieces_done_ - input_pieces);
            cost_done_ += cost_of_product_ * static_cast<double>(sums_.products_of(
                                                 (pieces_done_ - input_pieces) % sums_.slices()));
        } else {
            transform_output(pieces_done_ - input_pieces - sum_pieces_);
            cost_done_ += step_cost_;
        }
        ++pieces_done_;
    }
}

void TailLevel::transform_input(std::size_t piece) noexcept {
    const std::size_t input = piece / transform_.steps();
    transform_.forward_step(piece % transform_.steps(), window(2, input), window(1, input),
                            work_.data(), history_.spectrum(input, 0));
}

void TailLevel::sum_products(std::size_t piece) noexcept {
    const std::size_t group = piece / sums_.slices();
    const std::size_t first = group * chunks_of_piece(outputs_);
    const std::size_t last = std::min(first + chunks_of_piece(outputs_), transform_.chunks());
    sums_.set_slice(piece % sums_.slices(), first, last, current_sums_.data(), next_sums_.data());
}

void TailLevel::transform_output(std::size_t piece) noexcept {
    const std::size_t steps = transform_.steps();
    const std::size_t voices = sums_.differs() ? 2 : 1;
    const std::size_t output = piece / (voices * steps);
    const std::size_t step = piece % steps;
    const bool of_next = piece / steps % voices == 1;
    const float* const sums = (of_next ? next_sums_ : current_sums_).data();
    float* const out = (of_next ? computed_.faded_in : computed_.samples).data();
    transform_.inverse_step(step, sums + output * kChunk_floats, outputs_ * kChunk_floats,
                            work_.data(), out + output * level_.size);
}

void TailLevel::finish_frame() noexcept {
    if (output_pieces_ == 0) std::fill(computed_.samples.begin(), computed_.samples.end(), 0.0F);
    computed_.fades = sums_.differs();
    std::swap(heard_, computed_);
    current_ = std::exchange(next_, nullptr);
    position_ = 0;
    incoming_ = incoming_ == 2 ? 0 : incoming_ + 1;
}

}  // namespace aula
