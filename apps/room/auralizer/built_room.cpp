#include "apps/room/auralizer/built_room.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "apps/room/base/output_resources.h"
#include "apps/room/frames/ray_budget.h"
#include "audio/render/render_memory.h"

namespace aula {

namespace {

/// Time for which a removed source is audible beyond its response: its fade and the length of the
/// filters.
constexpr double kRingTail_s = 0.1;

/// Slots of the renderer beyond AuralizerOptions::max_sources. The slot of a removed source is
/// free for a while before another source plays in it.
constexpr std::size_t kSpareSlots = 2;

FrameSettings settings_of(std::size_t sources, const AuralizerOptions& options, int block,
                          const HeadphoneFilter* headphones) {
    // Not more spare slots than sources that can be added without a removal: if there are
    // max_sources sources from the beginning on, replacing one is rare.
    const std::size_t spare = std::min(options.max_sources - sources, kSpareSlots);
    FrameSettings settings{options};
    settings.block = block;
    settings.max_sources = options.max_sources + spare;
    settings.listeners = options.listeners;
    settings.waves_ready =
        options.clock == RenderClock::real_time ? WavesReady::later : WavesReady::at_once;
    if (headphones != nullptr) settings.headphones_bytes = equalizer_bytes(*headphones, block);
    settings.max_memory_bytes = options.max_memory_bytes;
    return settings;
}

std::optional<int> rays_of(const Scene& scene, const AuralizerOptions& options) {
    if (options.clock == RenderClock::exact) return {};
    return live_rays(scene.simulation);
}

}  // namespace

BuiltRoom::BuiltRoom(const Scene& scene_in, Sources sources_in, const AuralizerOptions& options,
                     int block, std::shared_ptr<const Hrtf> hrtf)
    : scene(std::make_shared<const Scene>(scene_in)),
      sources(sources_in),
      max_sources(options.max_sources),
      hrtf_file(options.hrtf),
      rate_hz(options.sample_rate_hz),
      rays(rays_of(*scene, options)),
      headphones(headphones_for(options)),
      computer(*scene,
               settings_of(sources == Sources::of_scene ? scene->sources.size() : 0, options, block,
                           headphones.get()),
               hrtf ? std::move(hrtf) : hrtf_for(options)),
      made(std::make_unique<SoundingRoom>(computer.config(), options.listeners, computer.hrtf(),
                                          headphones.get())),
      sounding(made.get()) {
    if (sources == Sources::of_room_before) computer.remove_sources();
    made->tail = tail_samples(computer.config().longest_delay_s);
}

double BuiltRoom::headphones_s() const {
    return headphones ? static_cast<double>(headphones->taps() - 1) / rate_hz : 0;
}

std::int64_t BuiltRoom::tail_samples(double longest_delay_s) const {
    const double length_s = std::max(computer.response_length_s(), longest_delay_s);
    return std::llround((length_s + headphones_s() + kRingTail_s) * rate_hz);
}

}  // namespace aula
