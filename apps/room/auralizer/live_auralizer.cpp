#include "apps/room/auralizer/live_auralizer.h"

#include <utility>

#include "apps/room/auralizer/auralizer_state.h"

namespace aula {

LiveAuralizer::LiveAuralizer(const Scene& scene, AuralizerOptions options)
    : room_(scene,
            [&] {
                options.clock = RenderClock::real_time;
                options.before_frame = [this](Auralizer&, double time_s) { before_frame_(time_s); };
                return std::make_unique<Auralizer::State>(scene, std::move(options));
            }()),
      playback_(static_cast<RealTimePlayback&>(*room_.state_->playback)) {}

void LiveAuralizer::start(std::function<void(double time_s)> before_frame, Hooks hooks) {
    before_frame_ = std::move(before_frame);
    playback_.set_hooks(std::move(hooks));
    room_.state_->begin();
}

void LiveAuralizer::stop() {
    room_.state_->end();
    playback_.free_engine();
}

std::shared_ptr<BuiltRoom> LiveAuralizer::build(const Scene& scene,
                                                const AuralizerOptions& options) const {
    return room_.state_->build_next(scene, BuiltRoom::Sources::of_scene, options);
}

std::uint64_t LiveAuralizer::begin(std::shared_ptr<BuiltRoom> next) {
    return playback_.begin_scene(std::move(next), kNow);
}

void LiveAuralizer::set_state(std::uint64_t scene, RoomState state) {
    playback_.change_scene(scene, kNow, [state = std::move(state)](FrameRoom& room) {
        RoomState next = state;
        for (std::size_t s = 0; s < next.sources.size(); ++s)
            next.sources[s].slot = room.state.sources[s].slot;
        next.listeners = room.state.listeners;
        room.state = std::move(next);
    });
}

}  // namespace aula
