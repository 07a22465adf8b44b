#include "engine/estimate/emission_plan.h"

#include <algorithm>

#include "engine/estimate/response_follower.h"

namespace aula {

namespace {

/// At rest a listener has at most this share of the rays of each source: what it gets if it has
/// half of the rays in its turns.
constexpr double kReserveShare = 0.5 / kReserveTurn;

/// It has rays of at most this number of frames. A choice: the noise of the frames that a response
/// in motion averages (ResponseFollower::kMostFrames).
constexpr int kReserveFrames = ResponseFollower::kMostFrames;

std::size_t count_changed(std::span<const EmitterStatus> emitters) {
    return static_cast<std::size_t>(std::count_if(
        emitters.begin(), emitters.end(), [](const EmitterStatus& e) { return e.changed; }));
}

/// A static emitter that needs rays.
struct StaticEmitter {
    int* batches;
    std::uint64_t emitted_rays;  // including those planned for this frame
};

/// Gives one batch to each emitter without rays, then batch by batch to the emitter with the
/// fewest.
void share(std::vector<StaticEmitter>& static_emitters, int max_batches, int batch_rays) {
    int left = kSharedEmitters * max_batches;
    const auto give = [&](StaticEmitter& to) {
        ++*to.batches;
        to.emitted_rays += static_cast<std::uint64_t>(batch_rays);
        --left;
    };
    for (StaticEmitter& s : static_emitters) {
        if (s.emitted_rays == 0) give(s);
    }
    while (left > 0) {
        StaticEmitter* fewest = nullptr;
        for (StaticEmitter& s : static_emitters) {
            if (*s.batches < max_batches && (!fewest || s.emitted_rays < fewest->emitted_rays))
                fewest = &s;
        }
        if (!fewest) return;
        give(*fewest);
    }
}

/// Gives half of the batches to the listener with the fewest rays if its reserve is not complete.
/// Returns the number of batches that are left for each source.
int plan_reserve(std::span<const EmitterStatus> sources, std::span<const EmitterStatus> listeners,
                 int max_batches, int batch_rays, EmissionPlan& plan) {
    if (sources.empty() || listeners.empty()) return max_batches;
    const auto fewest = [](std::span<const EmitterStatus> emitters) {
        return std::min_element(emitters.begin(), emitters.end(),
                                [](const EmitterStatus& a, const EmitterStatus& b) {
                                    return a.emitted_rays < b.emitted_rays;
                                });
    };
    const double most = std::min(kReserveShare * static_cast<double>(fewest(sources)->emitted_rays),
                                 double{kReserveFrames} * double(max_batches) * double(batch_rays));
    const auto listener = fewest(listeners);
    const int batches = (max_batches + 1) / 2;
    if (static_cast<double>(listener->emitted_rays) + double(batches) * batch_rays > most)
        return max_batches;
    plan.listeners[static_cast<std::size_t>(listener - listeners.begin())] = batches;
    return max_batches - batches;
}

}  // namespace

EmissionPlan plan_emission(std::span<const EmitterStatus> sources,
                           std::span<const EmitterStatus> listeners, bool turn_of_listeners,
                           int max_batches, int batch_rays) {
    EmissionPlan plan{std::vector<int>(sources.size(), 0), std::vector<int>(listeners.size(), 0)};
    const std::size_t changed_sources = count_changed(sources);
    const std::size_t changed_listeners = count_changed(listeners);
    if (turn_of_listeners && changed_sources == 0 && changed_listeners == 0)
        max_batches = plan_reserve(sources, listeners, max_batches, batch_rays, plan);
    std::vector<StaticEmitter> static_emitters;
    const auto send = [&](const EmitterStatus& emitter, int& batches) {
        if (emitter.changed) {
            batches = max_batches;
        } else if (!emitter.complete) {
            static_emitters.push_back({&batches, emitter.emitted_rays});
        }
    };
    // Listeners emit for the sources that have moved.
    bool all_listeners_send = changed_sources > 0;
    for (std::size_t l = 0; l < listeners.size(); ++l) {
        const bool fewer = changed_sources > changed_listeners;
        if (changed_sources > 0 && (!listeners[l].changed || fewer)) {
            send(listeners[l], plan.listeners[l]);
        } else {
            all_listeners_send = false;
        }
    }
    for (std::size_t s = 0; s < sources.size(); ++s) {
        if (!sources[s].changed || !all_listeners_send) send(sources[s], plan.sources[s]);
    }
    share(static_emitters, max_batches, batch_rays);
    return plan;
}

}  // namespace aula
