#include "audio/convolution/convolver_levels.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <utility>

namespace aula {

namespace {

/// Chunks times outputs whose products are summed in one task.
constexpr std::size_t kChunksPerTask = 8;

std::size_t chunks_per_task(std::size_t outputs) {
    return std::max<std::size_t>(1, kChunksPerTask / outputs);
}

/// Products per chunk that are summed in one task.
constexpr std::size_t kProductsPerTask = 16;

std::size_t slice_count(std::size_t products) {
    return (products + kProductsPerTask - 1) / kProductsPerTask;
}

/// A partition with its weights in two blends.
struct BlendedPartition {
    FilterPartition partition;
    float current = 0;
    float next = 0;
};

/// The different ones of two blends, at most four.
class BlendedPartitions {
 public:
    std::span<const BlendedPartition> all() const noexcept { return {partitions_.data(), count_}; }

    /// Adds the partitions of a blend that are not silent.
    void add(const FilterBlend& blend, std::size_t level, std::size_t input, std::size_t index,
             float BlendedPartition::*weight) noexcept {
        add(blend.from, 1 - blend.weight, level, input, index, weight);
        add(blend.to, blend.weight, level, input, index, weight);
    }

 private:
    void add(const ConvolutionFilter* filter, float weight, std::size_t level, std::size_t input,
             std::size_t index, float BlendedPartition::*member) noexcept {
        if (filter == nullptr || weight == 0) return;
        const FilterPartition& partition = filter->partitions(level, input)[index];
        if (partition.spectra == nullptr) return;
        const auto end = partitions_.begin() + static_cast<std::ptrdiff_t>(count_);
        const auto same = std::find_if(partitions_.begin(), end, [&](const BlendedPartition& p) {
            return p.partition.spectra == partition.spectra;
        });
        if (same == end) *same = {partition, 0, 0}, ++count_;
        float& sum = (*same).*member;
        // A partition that both filters have is there as a whole, without an error by rounding.
        sum = sum == 0 ? weight : 1;
    }

    std::array<BlendedPartition, 4> partitions_{};
    std::size_t count_ = 0;
};

}  // namespace

FrequencyDomainDelayLine::FrequencyDomainDelayLine(std::size_t inputs, const PartitionLevel& level)
    : ages_(level.count), size_(level.size), spectra_(inputs * ages_ * 2 * size_) {}

LevelSums::LevelSums(const ConvolutionShape& shape, const PartitionLevel& level, std::size_t index)
    : inputs_(shape.inputs),
      outputs_(shape.outputs),
      index_(index),
      multiply_add_(level.half_precision ? best_kernels().multiply_add_half
                                         : best_kernels().multiply_add) {
    for (Terms* const terms : {&shared_, &current_only_, &next_only_}) {
        terms->terms.resize(kTermsPerPartition * inputs_ * level.count);
    }
}

void LevelSums::collect(FrequencyDomainDelayLine& history, const FilterBlend& current,
                        const FilterBlend& next, std::size_t first, std::size_t last) noexcept {
    shared_.count = current_only_.count = next_only_.count = 0;
    for (std::size_t i = 0; i < inputs_; ++i) {
        for (std::size_t p = first; p < last; ++p) {
            BlendedPartitions partitions;
            partitions.add(current, index_, i, p, &BlendedPartition::current);
            partitions.add(next, index_, i, p, &BlendedPartition::next);
            const auto append = [&](Terms& list, const BlendedPartition& from, float weight) {
                list.terms[list.count++] = {history.spectrum(i, p), from.partition.spectra,
                                            weight * from.partition.scale};
            };
            for (const BlendedPartition& from : partitions.all()) {
                if (from.current == from.next) {
                    append(shared_, from, from.current);
                    continue;
                }
                if (from.current != 0) append(current_only_, from, from.current);
                if (from.next != 0) append(next_only_, from, from.next);
            }
        }
    }
}

void LevelSums::multiply_add(const Terms& terms, std::size_t chunks, float* sums) const noexcept {
    multiply_add_({terms.terms.data(), terms.count}, outputs_, 0, chunks, sums);
}

std::size_t LevelSums::slices() const noexcept {
    return slice_count(shared_.count) + slice_count(current_only_.count) +
           slice_count(next_only_.count);
}

SpectralTerms LevelSums::slice(std::size_t index) const noexcept {
    const Terms* terms = nullptr;
    for (const Terms* const candidate : {&shared_, &current_only_, &next_only_}) {
        terms = candidate;
        const std::size_t slices = slice_count(candidate->count);
        if (index < slices) break;
        index -= slices;
    }
    const std::size_t first = index * kProductsPerTask;
    assert(first < terms->count);
    const std::size_t available = terms->count - first;
    return {terms->terms.data() + first, std::min(kProductsPerTask, available), available};
}

std::size_t LevelSums::products_in_slice(std::size_t index) const noexcept {
    return slice(index).count;
}

void LevelSums::set_slice(std::size_t index, std::size_t first_chunk, std::size_t last_chunk,
                          float* current, float* next) const noexcept {
    const std::size_t first = first_chunk * outputs_ * kChunk_floats;
    const std::size_t count = (last_chunk - first_chunk) * outputs_ * kChunk_floats;
    if (index == 0) std::fill_n(current + first, count, 0.0F);
    // Both sums start from the shared one.
    if (differs() && index == slice_count(shared_.count)) {
        std::copy_n(current + first, count, next + first);
    }
    const bool of_next = index >= slice_count(shared_.count) + slice_count(current_only_.count);
    multiply_add_(slice(index), outputs_, first_chunk, last_chunk, of_next ? next : current);
}

void LevelSums::set(std::size_t chunks, bool with_next, float* current,
                    float* next) const noexcept {
    const std::size_t count = chunks * outputs_ * kChunk_floats;
    std::fill_n(current, count, 0.0F);
    multiply_add(shared_, chunks, current);
    if (with_next) std::copy_n(current, count, next);
    multiply_add(current_only_, chunks, current);
    if (with_next) multiply_add(next_only_, chunks, next);
}

void LevelSums::add(std::size_t chunks, bool with_next, float* current,
                    float* next) const noexcept {
    multiply_add(shared_, chunks, current);
    multiply_add(current_only_, chunks, current);
    if (!with_next) return;
    multiply_add(shared_, chunks, next);
    multiply_add(next_only_, chunks, next);
}

HeadLevel::HeadLevel(const ConvolutionShape& shape, const PartitionLevel& level,
                     std::size_t fade_samples)
    : inputs_(shape.inputs),
      outputs_(shape.outputs),
      level_(level),
      transform_(level.size),
      history_(shape.inputs, level),
      past_(shape, level, 0),
      present_(shape, level, 0),
      fade_(rounded_line(fade_samples)),
      windows_(shape.inputs * 2 * level.size),
      work_(transform_.work_floats()),
      output_(level.size),
      next_output_(level.size) {
    for (AlignedVector<float>* const sums : {&past_sums_, &next_past_sums_, &sums_, &next_sums_}) {
        sums->resize(2 * level.size * shape.outputs);
    }
}

void HeadLevel::exchange(const ConvolutionFilter* filter) noexcept {
    assert(filter != nullptr && !fading());
    next_ = filter;
    past_ready_ = false;
    fade_.start();
}

// The present partition is transformed with zeros in place of its future samples: the outputs up to
// the newest sample do not depend on them.
void HeadLevel::process(std::span<const float* const> inputs, std::span<float* const> outputs,
                        std::size_t offset, std::size_t samples) noexcept {
    for (std::size_t i = 0; i < inputs_; ++i) {
        float* const window = windows_.data() + i * 2 * level_.size;
        std::copy_n(inputs[i] + offset, samples, window + level_.size + filled_);
        transform_.forward(window, window + level_.size, work_.data(), history_.spectrum(i, 0));
    }
    const ConvolutionFilter* const next = fading() ? next_ : current_;
    const std::size_t chunks = transform_.chunks();
    if (!past_ready_) {
        past_.collect(history_, {current_}, {next}, 1, level_.count);
        present_.collect(history_, {current_}, {next}, 0, 1);
    }
    const bool differs = past_.differs() || present_.differs();
    if (!past_ready_) past_.set(chunks, differs, past_sums_.data(), next_past_sums_.data());
    past_ready_ = true;
    std::copy(past_sums_.begin(), past_sums_.end(), sums_.begin());
    if (differs) std::copy(next_past_sums_.begin(), next_past_sums_.end(), next_sums_.begin());
    present_.add(chunks, differs, sums_.data(), next_sums_.data());

    const std::size_t stride = outputs_ * kChunk_floats;
    for (std::size_t o = 0; o < outputs_; ++o) {
        float* const out = outputs[o] + offset;
        transform_.inverse(sums_.data() + o * kChunk_floats, stride, work_.data(), output_.data());
        std::copy_n(output_.data() + filled_, samples, out);
        if (!differs) continue;
        transform_.inverse(next_sums_.data() + o * kChunk_floats, stride, work_.data(),
                           next_output_.data());
        for (std::size_t n = 0; n < samples; ++n)
            out[n] += fade_.weight(n) * (next_output_[filled_ + n] - out[n]);
    }
    filled_ += samples;
    if (filled_ == level_.size) finish_partition();
    if (!fading()) return;
    fade_.advance(samples);
    if (!fade_.done()) return;
    current_ = std::exchange(next_, nullptr);
    past_ready_ = false;
}

void HeadLevel::finish_partition() noexcept {
    filled_ = 0;
    past_ready_ = false;
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
      fade_(rounded_line(level.size)),
      product_cost_(product_cost(shape, level, false)),
      exchanging_cost_(product_cost(shape, level, true)),
      step_cost_(transform_cost(level.size) / static_cast<double>(transform_.steps())),
      position_(lead_samples(shape, index)),
      windows_(3 * shape.inputs * level.size),
      sum_groups_((transform_.chunks() + chunks_per_task(shape.outputs) - 1) /
                  chunks_per_task(shape.outputs)),
      // The input before the first segment is silence, whose spectra are already stored.
      tasks_done_(shape.inputs * transform_.steps()),
      current_sums_(2 * level.size * shape.outputs),
      next_sums_(2 * level.size * shape.outputs),
      work_(transform_.work_floats()),
      next_output_(level.size),
      playing_(shape.outputs * level.size),
      computed_(shape.outputs * level.size) {}

void TailLevel::process(std::span<const float* const> inputs, std::span<float* const> outputs,
                        std::size_t offset, std::size_t samples,
                        const FilterBlend& newest) noexcept {
    assert(position_ + samples <= level_.size);
    if (position_ == 0) start_segment(newest);
    for (std::size_t i = 0; i < inputs_; ++i) {
        std::copy_n(inputs[i] + offset, samples, window(0, i) + position_);
    }
    for (std::size_t o = 0; o < outputs_; ++o) {
        const float* const playing = playing_.data() + o * level_.size + position_;
        float* const out = outputs[o] + offset;
        for (std::size_t n = 0; n < samples; ++n) out[n] += playing[n];
    }
    position_ += samples;
    work_until(segment_cost_ * static_cast<double>(position_) / static_cast<double>(level_.size));
    if (position_ == level_.size) finish_segment();
}

void TailLevel::start_segment(const FilterBlend& newest) noexcept {
    history_.advance();
    next_ = level_.blends() ? newest : newest.nearer();
    sums_.collect(history_, current_, next_, 0, level_.count);
    const std::size_t filters = sums_.product_count() == 0 ? 0 : sums_.differs() ? 2 : 1;
    output_tasks_ = outputs_ * filters * transform_.steps();
    sum_tasks_ = sum_groups_ * sums_.slices();
    group_product_cost_ = (sums_.differs() ? exchanging_cost_ : product_cost_) *
                          static_cast<double>(chunks_per_task(outputs_));
    tasks_done_ = 0;
    cost_done_ = 0;
    const std::size_t steps = inputs_ * transform_.steps() + output_tasks_;
    segment_cost_ = step_cost_ * static_cast<double>(steps) +
                    group_product_cost_ * static_cast<double>(sum_groups_ * sums_.product_count());
}

void TailLevel::work_until(double due) noexcept {
    const std::size_t input_tasks = inputs_ * transform_.steps();
    const std::size_t all = input_tasks + sum_tasks_ + output_tasks_;
    // At the end of the segment all tasks run, regardless of rounding of the cost.
    while (tasks_done_ < all && (cost_done_ < due || position_ == level_.size)) {
        if (tasks_done_ < input_tasks) {
            transform_input(tasks_done_);
            cost_done_ += step_cost_;
        } else if (tasks_done_ < input_tasks + sum_tasks_) {
            sum_products(tasks_done_ - input_tasks);
            cost_done_ += group_product_cost_ * static_cast<double>(sums_.products_in_slice(
                                                    (tasks_done_ - input_tasks) % sums_.slices()));
        } else {
            transform_output(tasks_done_ - input_tasks - sum_tasks_);
            cost_done_ += step_cost_;
        }
        ++tasks_done_;
    }
}

void TailLevel::transform_input(std::size_t task) noexcept {
    const std::size_t input = task / transform_.steps();
    transform_.forward_step(task % transform_.steps(), window(2, input), window(1, input),
                            work_.data(), history_.spectrum(input, 0));
}

void TailLevel::sum_products(std::size_t task) noexcept {
    const std::size_t group = task / sums_.slices();
    const std::size_t first = group * chunks_per_task(outputs_);
    const std::size_t last = std::min(first + chunks_per_task(outputs_), transform_.chunks());
    sums_.set_slice(task % sums_.slices(), first, last, current_sums_.data(), next_sums_.data());
}

void TailLevel::transform_output(std::size_t task) noexcept {
    const std::size_t steps = transform_.steps();
    const std::size_t filters = sums_.differs() ? 2 : 1;
    const std::size_t output = task / (filters * steps);
    const std::size_t step = task % steps;
    const bool of_next = task / steps % filters == 1;
    const float* const sums = (of_next ? next_sums_ : current_sums_).data();
    float* const computed = computed_.data() + output * level_.size;
    transform_.inverse_step(step, sums + output * kChunk_floats, outputs_ * kChunk_floats,
                            work_.data(), of_next ? next_output_.data() : computed);
    if (!of_next || step + 1 < steps) return;
    for (std::size_t n = 0; n < level_.size; ++n) {
        computed[n] += fade_[n] * (next_output_[n] - computed[n]);
    }
}

void TailLevel::finish_segment() noexcept {
    if (output_tasks_ == 0) std::fill(computed_.begin(), computed_.end(), 0.0F);
    std::swap(playing_, computed_);
    current_ = std::exchange(next_, {});
    position_ = 0;
    incoming_ = incoming_ == 2 ? 0 : incoming_ + 1;
}

}  // namespace aula
