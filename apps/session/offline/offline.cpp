#include "apps/session/offline/offline.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "apps/session/base/blocking_queue.h"
#include "apps/session/base/formatted.h"
#include "apps/session/frames/frame_maker.h"
#include "apps/session/frames/signals.h"
#include "apps/session/frames/sound_at_listener.h"
#include "apps/session/frames/timeline.h"
#include "audio/base/realtime.h"
#include "audio/dsp/limiter.h"

namespace aula {

namespace {

/// Frames that wait until the renderer needs them: a slow frame is made up for by fast ones.
constexpr std::size_t kFramesAhead = 2;

/// Computes the frames of a walk in order on a second thread, a few ahead. The work ahead is
/// limited by the frames that are ready and not by those that exist: how many of them the renderer
/// holds cannot stop the thread. What is computed does not depend on when.
class FramePipeline {
 public:
    FramePipeline(FrameMaker& maker, const Scene& scene, std::int64_t frame_count)
        : maker_(maker), scene_(scene), frame_count_(frame_count), thread_([this] { run(); }) {}
    ~FramePipeline() {
        ready_.close();
        thread_.join();
    }
    FramePipeline(const FramePipeline&) = delete;
    FramePipeline& operator=(const FramePipeline&) = delete;

    /// The next frame; waits for it. Throws what the computation threw.
    std::unique_ptr<RenderFrame> next() {
        if (auto frame = ready_.pop()) return std::move(*frame);
        std::rethrow_exception(failure_);
    }

    /// To be filled again.
    void give_back(std::unique_ptr<RenderFrame> frame) {
        const std::lock_guard lock(mutex_);
        spent_.push_back(std::move(frame));
    }

 private:
    /// A spent frame, or a new one where the renderer holds all.
    std::unique_ptr<RenderFrame> unused_frame() {
        {
            const std::lock_guard lock(mutex_);
            if (!spent_.empty()) {
                auto frame = std::move(spent_.back());
                spent_.pop_back();
                return frame;
            }
        }
        return maker_.make_frame();
    }

    void run() {
        try {
            const auto frame_rate_hz = static_cast<double>(scene_.simulation.frame_rate_hz);
            for (std::int64_t k = 0; k < frame_count_; ++k) {
                auto frame = unused_frame();
                maker_.fill(static_cast<double>(k) / frame_rate_hz, {}, *frame);
                if (!ready_.push(std::move(frame))) return;
            }
        } catch (...) {
            failure_ = std::current_exception();
            ready_.close();
        }
    }

    FrameMaker& maker_;
    const Scene& scene_;
    std::int64_t frame_count_;
    std::exception_ptr failure_;  ///< read once ready_ is closed
    BlockingQueue<std::unique_ptr<RenderFrame>> ready_{kFramesAhead};
    std::mutex mutex_;  ///< of what follows
    std::vector<std::unique_ptr<RenderFrame>> spent_;
    std::thread thread_;  ///< started last
};

/// Planar buffers of one block, and pointers to them as the audio side takes them.
struct PlanarBlock {
    PlanarBlock(std::size_t channel_count, std::size_t sample_count)
        : samples(channel_count, std::vector<float>(sample_count)) {
        for (auto& channel : samples) {
            pointers.push_back(channel.data());
            const_pointers.push_back(channel.data());
        }
    }
    std::vector<std::vector<float>> samples;
    std::vector<float*> pointers;
    std::vector<const float*> const_pointers;
};

/// The audio side of a walk, block by block.
class BlockRenderer {
 public:
    BlockRenderer(const Scene& scene, FrameMaker& maker, const SignalSet& signals,
                  const Timeline& timeline, std::shared_ptr<const Hrtf> hrtf)
        : scene_(scene),
          signals_(signals),
          timeline_(timeline),
          rate_hz_(maker.config().sample_rate_hz),
          block_(maker.config().block),
          renderer_(maker.config(), std::move(hrtf)),
          head_(frame_samples(maker.config())),
          inputs_(signals.size(), static_cast<std::size_t>(block_)),
          frame_count_(frames_before(std::llround(timeline.end_s * rate_hz_))),
          pipeline_(maker, scene, frame_count_) {}

    /// Renders the block that starts at sample `first`.
    void render(std::int64_t first, std::span<float* const> outputs) {
        take_frames_before(first + block_);
        for (std::size_t s = 0; s < signals_.size(); ++s) {
            signals_[s]->read(first, first, inputs_.samples[s]);
            timeline_.fade(first, rate_hz_, inputs_.samples[s]);
        }
        renderer_.render(inputs_.const_pointers, head_.advance(block_), outputs, block_);
    }

 private:
    /// Number of frames whose time lies before that of a sample.
    std::int64_t frames_before(std::int64_t sample) const {
        return static_cast<std::int64_t>(
            std::ceil(static_cast<double>(sample) *
                      static_cast<double>(scene_.simulation.frame_rate_hz) / rate_hz_));
    }

    /// Publishes the newest frame whose time lies in the block that ends before `end`.
    void take_frames_before(std::int64_t end) {
        const std::int64_t wanted = std::min(frames_before(end), frame_count_);
        std::unique_ptr<RenderFrame> newest;
        for (; frames_taken_ < wanted; ++frames_taken_) {
            if (newest) pipeline_.give_back(std::move(newest));
            newest = pipeline_.next();
        }
        if (!newest) return;
        renderer_.mailbox().publish(std::move(newest));
        while (auto spent = renderer_.mailbox().reclaim()) pipeline_.give_back(std::move(spent));
        const double time_s = static_cast<double>(frames_taken_ - 1) /
                              static_cast<double>(scene_.simulation.frame_rate_hz);
        head_.turn_to(scene_.listener.pose_at(time_s));
    }

    const Scene& scene_;
    const SignalSet& signals_;
    const Timeline& timeline_;
    double rate_hz_;
    int block_;
    Renderer renderer_;
    HeadMotion head_;
    PlanarBlock inputs_;
    std::int64_t frame_count_;
    std::int64_t frames_taken_ = 0;
    FramePipeline pipeline_;
};

}  // namespace

bool render_offline(const Scene& scene, const SessionOptions& options,
                    const std::filesystem::path& file, const Progress& progress,
                    std::vector<std::string>& warnings) {
    const double rate_hz = options.sample_rate_hz;
    const std::size_t channels = channel_count(options.output);
    WavWriter writer(file, rate_hz, channels, options.format);
    const SignalSet signals = read_signals(scene, rate_hz);
    const std::vector<std::string> odd = warnings_of(signals);
    warnings.insert(warnings.end(), odd.begin(), odd.end());
    const auto hrtf = hrtf_for(options, rate_hz);
    FrameMaker maker(scene, rate_hz, options, hrtf);
    const Timeline timeline = offline_timeline({.scene = scene,
                                                .signals = signals,
                                                .sample_rate_hz = rate_hz,
                                                .response_length_s = maker.response_length_s(),
                                                .duration_s = options.duration_s});
    BlockRenderer renderer(scene, maker, signals, timeline, hrtf);

    const FlushDenormals flush;
    std::optional<Limiter> limiter;
    if (options.format != SampleFormat::float32) limiter.emplace(rate_hz, channels, options.block);
    // The limiter's delay is cut off the start and made up for at the end.
    std::int64_t skip = limiter ? limiter->latency_samples() : 0;
    const std::int64_t total = std::llround(timeline.end_s * rate_hz) + skip;
    PlanarBlock output(channels, static_cast<std::size_t>(options.block));
    std::vector<float> interleaved;
    std::int64_t muted = 0;
    for (std::int64_t first = 0; first < total; first += options.block) {
        renderer.render(first, output.pointers);
        if (limiter) {
            limiter->process(output.pointers, options.block);
            muted += static_cast<std::int64_t>(limiter->muted_samples());
        }
        const std::int64_t end = std::min<std::int64_t>(options.block, total - first);
        interleaved.clear();
        for (std::int64_t i = std::min(skip, end); i < end; ++i)
            for (const auto& channel : output.samples)
                interleaved.push_back(channel[static_cast<std::size_t>(i)]);
        skip -= std::min(skip, end);
        writer.write(interleaved);
        if (progress && !progress(static_cast<double>(first + end) / static_cast<double>(total)))
            return false;
    }
    if (muted += writer.muted_samples(); muted > 0) warnings.push_back(muted_text(muted));
    writer.commit();
    return true;
}

}  // namespace aula
