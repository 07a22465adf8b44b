#include "apps/bench/convolution/convolution_peers.h"

#include <memory>

#include "apps/bench/convolution/fft_libraries.h"
#include "apps/bench/convolution/uniform_convolver.h"
#ifdef AULA_BENCH_ZITA
#include "apps/bench/convolution/zita_convolver.h"
#endif

namespace aula::bench {

namespace {

template <typename Convolver>
std::shared_ptr<Convolver> set_filters(std::shared_ptr<Convolver> convolver,
                                       const ConvolutionFilters& filters) {
    for (std::size_t s = 0; s < filters.size(); ++s) {
        for (std::size_t o = 0; o < filters[s].size(); ++o) {
            convolver->set_filter(s, o, filters[s][o]);
        }
    }
    return convolver;
}

template <typename Convolver>
std::function<void()> processing(std::shared_ptr<Convolver> convolver,
                                 const ConvolutionSignals& signals) {
    return [convolver, &signals] { convolver->process(signals.inputs, signals.outputs); };
}

}  // namespace

std::vector<ConvolutionPeer> convolution_peers() {
    std::vector<ConvolutionPeer> peers;
    for (const FftLibrary& library : fft_libraries()) {
        peers.push_back({"textbook, " + library.name, false,
                         [library](const ConvolutionCase& c, const ConvolutionFilters& filters,
                                   const ConvolutionSignals& signals) {
                             return processing(
                                 set_filters(std::make_shared<UniformConvolver>(
                                                 library, c.sources, c.channels, c.block, c.taps()),
                                             filters),
                                 signals);
                         }});
    }
#ifdef AULA_BENCH_ZITA
    for (const bool uniform : {true, false}) {
        peers.push_back({uniform ? "zita, uniform" : "zita", !uniform,
                         [uniform](const ConvolutionCase& c, const ConvolutionFilters& filters,
                                   const ConvolutionSignals& signals) {
                             const auto zita =
                                 set_filters(std::make_shared<ZitaConvolver>(
                                                 c.sources, c.channels, c.block, c.taps(), uniform),
                                             filters);
                             zita->start();
                             return processing(zita, signals);
                         }});
    }
#endif
    return peers;
}

}  // namespace aula::bench
