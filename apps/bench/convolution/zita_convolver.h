#pragma once

#include <cstddef>
#include <memory>
#include <span>

namespace aula::bench {

/// zita-convolver, either with partitions of one block in the calling thread, or with growing
/// partitions in separate threads, for which each call waits.
class ZitaConvolver {
 public:
    /// Throws InputError if zita-convolver refuses.
    ZitaConvolver(std::size_t inputs, std::size_t outputs, std::size_t block, std::size_t taps,
                  bool uniform);
    ~ZitaConvolver();

    void set_filter(std::size_t input, std::size_t output, std::span<const float> taps);

    /// Call once, after the filters are set.
    void start();

    /// Overwrites the outputs; one block.
    void process(std::span<const float* const> inputs, std::span<float* const> outputs);

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula::bench
