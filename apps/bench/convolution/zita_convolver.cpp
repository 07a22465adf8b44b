#include "apps/bench/convolution/zita_convolver.h"

#include <sched.h>
#include <zita-convolver.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "aula/exception.h"

namespace aula::bench {

namespace {

void need(int result, const char* what) {
    if (result != 0) throw InputError(std::string("zita-convolver: ") + what + " failed");
}

}  // namespace

struct ZitaConvolver::State {
    Convproc convolver;
    std::uint32_t block;
};

ZitaConvolver::ZitaConvolver(std::size_t inputs, std::size_t outputs, std::size_t block,
                             std::size_t taps, bool uniform)
    : state_(std::make_unique<State>()) {
    state_->block = static_cast<std::uint32_t>(block);
    // Its fastest options.
    state_->convolver.set_options(Convproc::OPT_VECTOR_MODE | Convproc::OPT_FFTW_MEASURE);
    const std::uint32_t largest = uniform ? state_->block : std::uint32_t{Convproc::MAXPART};
    need(state_->convolver.configure(
             static_cast<std::uint32_t>(inputs), static_cast<std::uint32_t>(outputs),
             static_cast<std::uint32_t>(taps), state_->block, state_->block, largest, 0.0F),
         "configure");
}

ZitaConvolver::~ZitaConvolver() {
    state_->convolver.stop_process();
    state_->convolver.cleanup();
}

void ZitaConvolver::set_filter(std::size_t input, std::size_t output, std::span<const float> taps) {
    std::vector<float> copy(taps.begin(), taps.end());  // the library requires a mutable buffer
    need(state_->convolver.impdata_create(static_cast<std::uint32_t>(input),
                                          static_cast<std::uint32_t>(output), 1, copy.data(), 0,
                                          static_cast<std::int32_t>(copy.size())),
         "impdata_create");
}

void ZitaConvolver::start() {
    need(state_->convolver.start_process(0, SCHED_OTHER), "start_process");
}

void ZitaConvolver::process(std::span<const float* const> inputs, std::span<float* const> outputs) {
    for (std::size_t i = 0; i < inputs.size(); ++i) {
        std::copy_n(inputs[i], state_->block,
                    state_->convolver.inpdata(static_cast<std::uint32_t>(i)));
    }
    state_->convolver.process(true);
    for (std::size_t o = 0; o < outputs.size(); ++o) {
        std::copy_n(state_->convolver.outdata(static_cast<std::uint32_t>(o)), state_->block,
                    outputs[o]);
    }
}

}  // namespace aula::bench
