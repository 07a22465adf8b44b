#include "apps/room/auralizer/live_auralizer.h"

#include <utility>

#include "apps/room/auralizer/auralizer_state.h"

namespace aula {

LiveAuralizer::LiveAuralizer(const Scene& scene, AuralizerOptions options,
                             std::shared_ptr<const Hrtf> hrtf)
    : room_(scene,
            [&] {
                options.clock = RenderClock::real_time;
                options.before_frame = [this](Auralizer&, double time_s) { before_frame_(time_s); };
                return std::make_unique<Auralizer::State>(scene, std::move(options),
                                                          std::move(hrtf));
            }()),
      playback_(static_cast<RealTimePlayback&>(*room_.state_->playback)) {}

void LiveAuralizer::warm_up(double longest_s) { playback_.warm_up(longest_s); }

const FrameMaker& LiveAuralizer::compute_first(double time_s) {
    return playback_.compute_first(time_s);
}

void LiveAuralizer::start(Hooks hooks) {
    before_frame_ = std::move(hooks.before_frame);
    playback_.follow(std::move(hooks.played_s), std::move(hooks.after_frame));
    room_.state_->begin();
}

void LiveAuralizer::stop() {
    room_.state_->end();
    playback_.free_engine();
}

}  // namespace aula
