#include "apps/room/offline/static_propagation.h"

#include <utility>

#include "apps/room/frames/ray_budget.h"
#include "apps/room/offline/response_mean.h"
#include "engine/base/sampling.h"
#include "engine/base/worker_pool.h"

namespace aula {

namespace {

/// True if, of the responses of `frames` frames from empty caches, the last has a smaller error
/// than the mean of all. The last response of `patch` contains all frames. That of `dpc` contains
/// the newest frames, as many as its window; the mean of all responses weights the first rays most.
/// The last is better up to 1.5 windows (measured).
bool last_is_best(const Simulation& simulation, int frames) {
    switch (simulation.estimator) {
        case Estimator::pt:
        case Estimator::dpc_published:
            return false;
        case Estimator::dpc:
            return 2 * frames <= 3 * simulation.window_frames();
        case Estimator::patch:
            return true;
    }
    return true;
}

std::vector<Vec3> positions_of(std::span<const Pose> poses) {
    std::vector<Vec3> positions;
    for (const Pose& pose : poses) positions.push_back(pose.position);
    return positions;
}

}  // namespace

StaticPropagation::StaticPropagation(const Scene& scene, std::span<const Pose> receivers)
    : simulation_(scene.simulation),
      receivers_(positions_of(receivers)),
      listeners_(scene.simulation.estimator == Estimator::patch ? 1 : receivers.size()) {
    const auto find_images = [&] {
        if (auto found = BoxImages::find(scene, receivers, response_length_s_))
            images_ = std::make_shared<const BoxImages>(std::move(*found));
    };
    if (scene.simulation.ir_length_s) {
        response_length_s_ = double{*scene.simulation.ir_length_s};
        find_images();
    }
    if (!images_) {
        propagation_.emplace(scene, scene.simulation, listeners_, receivers_);
        response_length_s_ = propagation_->response_length_s();
        if (!scene.simulation.ir_length_s) find_images();
    }
    if (images_) propagation_.reset();
    input_.listeners.assign(receivers_.begin(),
                            receivers_.begin() + static_cast<std::ptrdiff_t>(listeners_));
    for (const Source& source : scene.sources) {
        input_.sources.push_back(source.position_at(0));
        input_.source_rotations.push_back(source.pose_at(0).rotation());
    }
}

/// Rays of a source and of a gather cost about the same. The error of T30 at a receiver that
/// gathers once in eight frames is 1.3 times that with gathers in every second frame, for the same
/// time of six receivers (`aula report` of a lecture hall). Hundreds of receivers share the rays of
/// the sources for less.
int StaticPropagation::gather_frames(std::size_t further_receivers) {
    return further_receivers <= 8 ? 2 : further_receivers <= 16 ? 4 : 8;
}

/// True for the frames after which the receivers that are not listeners gather.
bool StaticPropagation::gathers_at(int frame, int count) const {
    const std::size_t further = receivers_.size() - listeners_;
    return further > 0 && ((frame + 1) % gather_frames(further) == 0 || frame + 1 == count);
}

std::vector<EnergyResponse> StaticPropagation::window(int count,
                                                      const std::function<bool(int)>& continues) {
    if (images_) {
        frames_ += count;
        return continues(frames_) ? image_responses(input_.sources.size())
                                  : std::vector<EnergyResponse>();
    }
    if (windows_ > 0) propagation_->restart(derive_seed(simulation_.seed, windows_));
    ++windows_;
    const bool last = last_is_best(simulation_, count);
    const std::size_t receivers = receivers_.size();
    const std::span<const Vec3> others = std::span(receivers_).subspan(listeners_);
    std::vector<ResponseMean> means(input_.sources.size() * receivers);
    for (int frame = 0; frame < count; ++frame) {
        propagation_->step(input_);
        for (std::size_t s = 0; (!last || frame + 1 == count) && s < input_.sources.size(); ++s)
            for (std::size_t r = 0; r < listeners_; ++r)
                means[s * receivers + r].add(propagation_->response(s, r));
        if (gathers_at(frame, count)) {
            const std::vector<EnergyResponse> gathered = propagation_->responses_at(input_, others);
            // A gather is weighted by the rays in the caches.
            for (std::size_t i = 0; i < gathered.size(); ++i)
                means[i / others.size() * receivers + listeners_ + i % others.size()].add(
                    gathered[i], frame + 1);
        }
        work_s_ += counted_s(propagation_->statistics());
        if (!continues(++frames_)) return {};
    }
    std::vector<EnergyResponse> responses;
    responses.reserve(means.size());
    for (const ResponseMean& mean : means) responses.push_back(mean.value());
    return responses;
}

/// [pair]
std::vector<EnergyResponse> StaticPropagation::image_responses(std::size_t sources) const {
    std::vector<EnergyResponse> responses(sources * receivers_.size());
    WorkerPool workers(simulation_.threads.value_or(default_threads()));
    workers.run(responses.size(), [&](std::size_t pair) {
        responses[pair] = images_->response(pair / receivers_.size(), pair % receivers_.size());
    });
    return responses;
}

std::vector<char> StaticPropagation::connected() const {
    if (images_) return std::vector<char>(input_.sources.size() * receivers_.size(), 1);
    FrameInput input = input_;
    std::vector<char> pairs(input.sources.size() * receivers_.size());
    for (std::size_t r = 0; r < receivers_.size(); ++r) {
        input.listeners = {receivers_[r]};
        const std::vector<char> sources = propagation_->sources_connected(input);
        for (std::size_t s = 0; s < sources.size(); ++s)
            pairs[s * receivers_.size() + r] = sources[s];
    }
    return pairs;
}

}  // namespace aula
