#include "apps/session/player.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

#include "apps/session/frame_maker.h"
#include "apps/session/signals.h"
#include "apps/session/sound_at_listener.h"
#include "apps/session/timeline.h"
#include "audio/error.h"
#include "audio/limiter.h"
#include "audio/mailbox.h"

namespace aula {

namespace {

/// The audio thread's part: signals, renderer and limiter for one block after another. What other
/// threads read of it is atomic.
class LiveRenderer {
 public:
    LiveRenderer(const RendererConfig& config, std::vector<Signal> signals,
                 const Timeline& timeline, std::shared_ptr<const Hrtf> hrtf)
        : rate_hz_(config.sample_rate_hz),
          block_(config.block),
          signals_(std::move(signals)),
          timeline_(timeline),
          renderer_(config, std::move(hrtf)),
          limiter_(rate_hz_, channel_count(config.output), block_),
          head_(static_cast<int>(std::lround(config.frame_s * rate_hz_))),
          inputs_(signals_.size(), std::vector<float>(static_cast<std::size_t>(block_))) {
        for (const auto& input : inputs_) input_pointers_.push_back(input.data());
        output_pointers_.resize(channel_count(config.output));
    }

    /// Fills the outputs, in blocks of our own size where the device asks for more.
    /// [audio thread, wait-free]
    void render(std::span<float* const> outputs, int samples) noexcept {
        for (int done = 0; done < samples; done += block_) {
            for (std::size_t c = 0; c < output_pointers_.size(); ++c)
                output_pointers_[c] = outputs[c] + done;
            render_block(std::min(block_, samples - done));
        }
    }

    /// [propagation thread]
    Mailbox<RenderFrame>& frames() { return renderer_.mailbox(); }
    Mailbox<Pose>& head_poses() { return head_poses_; }

    /// [any thread]
    double time_s() const { return static_cast<double>(position_.load()) / rate_hz_; }
    float take_peak() { return peak_.exchange(0); }

 private:
    void render_block(int samples) noexcept {
        if (Pose* pose = head_poses_.take()) {
            head_.turn_to(*pose);
            head_poses_.give_back(pose);
        }
        const std::int64_t first = position_.load(std::memory_order_relaxed);
        for (std::size_t s = 0; s < signals_.size(); ++s) {
            const std::span<float> input(inputs_[s].data(), static_cast<std::size_t>(samples));
            signals_[s].read(first, input);
            timeline_.fade(first, rate_hz_, input);
        }
        renderer_.render(input_pointers_, head_.advance(samples), output_pointers_, samples);
        limiter_.process(output_pointers_, samples);
        float peak = peak_.load(std::memory_order_relaxed);
        for (const float* channel : output_pointers_)
            for (int i = 0; i < samples; ++i) peak = std::max(peak, std::abs(channel[i]));
        peak_.store(peak, std::memory_order_relaxed);
        position_.store(first + samples, std::memory_order_relaxed);
    }

    double rate_hz_;
    int block_;
    std::vector<Signal> signals_;
    Timeline timeline_;
    Renderer renderer_;
    Limiter limiter_;
    HeadMotion head_;
    Mailbox<Pose> head_poses_;
    std::vector<std::vector<float>> inputs_;
    std::vector<const float*> input_pointers_;
    std::vector<float*> output_pointers_;
    std::atomic<std::int64_t> position_ = 0;
    std::atomic<float> peak_ = 0;
};

}  // namespace

struct Player::State {
    using Clock = std::chrono::steady_clock;

    State(const Scene& scene, const SessionOptions& options);
    ~State();

    void build(const SessionOptions& options);
    void open_device(const SessionOptions& options);
    void propagate();
    void compute(std::int64_t k);
    void publish();

    Scene scene;
    double frame_rate_hz;
    double rate_hz = 0;
    std::vector<std::string> warnings;
    Timeline timeline;
    std::unique_ptr<FrameMaker> maker;
    std::unique_ptr<LiveRenderer> renderer;

    std::unique_ptr<RenderFrame> computed;  ///< waits for its time to be published
    Pose computed_pose;

    std::mutex mutex;  ///< of what follows
    std::condition_variable stopping;
    bool stop = false;
    Pose wanted_pose;  ///< where move_listener put the listener
    PlayStatus status;
    double frame_sum_ms = 0;
    std::exception_ptr failure;

    std::unique_ptr<AudioDevice> device;  ///< ends before the renderer that it calls
    std::thread thread;
};

Player::State::State(const Scene& scene_in, const SessionOptions& options)
    : scene(scene_in),
      frame_rate_hz(static_cast<double>(scene.simulation.frame_rate_hz)),
      wanted_pose(scene.listener.pose_at(0)) {
    rate_hz = options.sample_rate_hz;
    build(options);
    try {
        open_device(options);
    } catch (const SampleRateRefused& refused) {
        rate_hz = refused.device_rate_hz();
        build(options);
        open_device(options);
        warnings.push_back("the output device \"" + device->info().name + "\" plays at " +
                           std::to_string(std::lround(rate_hz)) + " Hz, not at " +
                           std::to_string(std::lround(options.sample_rate_hz)));
    }
    compute(0);
    publish();
    device->start();
    thread = std::thread([this] {
        try {
            propagate();
        } catch (...) {
            const std::lock_guard lock(mutex);
            failure = std::current_exception();
        }
    });
}

Player::State::~State() {
    if (thread.joinable()) {
        {
            const std::lock_guard lock(mutex);
            stop = true;
        }
        stopping.notify_one();
        thread.join();
    }
    if (device) device->stop();
}

/// Everything but the device: what is wrong with the input is said before a device is opened.
void Player::State::build(const SessionOptions& options) {
    std::vector<Signal> signals = read_signals(scene, rate_hz);
    warnings.clear();
    for (const Signal& signal : signals)
        warnings.insert(warnings.end(), signal.warnings().begin(), signal.warnings().end());
    const auto hrtf = hrtf_for(options, rate_hz);
    maker = std::make_unique<FrameMaker>(scene, rate_hz, options.block, options.output, hrtf);
    timeline = live_timeline({.scene = scene,
                              .signals = signals,
                              .sample_rate_hz = rate_hz,
                              .response_length_s = maker->response_length_s(),
                              .duration_s = options.duration_s});
    renderer = std::make_unique<LiveRenderer>(maker->config(), std::move(signals), timeline, hrtf);
}

void Player::State::open_device(const SessionOptions& options) {
    device = std::make_unique<AudioDevice>(options.device, rate_hz, channel_count(options.output),
                                           options.block,
                                           [this](std::span<float* const> outputs, int samples) {
                                               renderer->render(outputs, samples);
                                           });
}

/// Wakes at each frame time t_k: publishes the frame computed since the one before, then computes
/// the next for the newest pose. [propagation thread]
void Player::State::propagate() {
    // Where on the clock the sound's time zero lies. Corrected slowly towards the time that was
    // really played, as a device's clock is never quite this one; a fiftieth each frame leaves
    // less than 0.1 ms of the jitter that comes from sound being played in blocks.
    constexpr double kCorrection = 0.02;
    Clock::time_point zero = Clock::now();
    const auto at = [&](double time_s) {
        return zero +
               std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(time_s));
    };
    for (std::int64_t k = 1;; ++k) {
        std::unique_lock lock(mutex);
        const auto frame_time = at(static_cast<double>(k) / frame_rate_hz);
        if (stopping.wait_until(lock, frame_time, [this] { return stop; })) return;
        lock.unlock();
        publish();

        const double now_s = std::chrono::duration<double>(Clock::now() - zero).count();
        // Frame times that have passed meanwhile are left out.
        const auto newest = static_cast<std::int64_t>(std::floor(now_s * frame_rate_hz));
        if (newest > k) {
            lock.lock();
            status.late_frames += static_cast<std::uint64_t>(newest - k);
            lock.unlock();
            k = newest;
        }
        compute(k);
        zero -= std::chrono::duration_cast<Clock::duration>(
            std::chrono::duration<double>(kCorrection * (renderer->time_s() - now_s)));
    }
}

void Player::State::compute(std::int64_t k) {
    const Clock::time_point begin = Clock::now();
    const double time_s = static_cast<double>(k) / frame_rate_hz;
    {
        const std::lock_guard lock(mutex);
        computed_pose = scene.listener.path ? scene.listener.pose_at(time_s) : wanted_pose;
    }
    computed = renderer->frames().reclaim();
    if (!computed) computed = maker->make_frame();
    maker->fill(time_s, computed_pose, *computed);

    const double took_ms = std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
    const std::lock_guard lock(mutex);
    frame_sum_ms += took_ms;
    ++status.frames;
    status.frame_mean_ms = frame_sum_ms / static_cast<double>(status.frames);
    status.frame_worst_ms = std::max(status.frame_worst_ms, took_ms);
}

void Player::State::publish() {
    if (!computed) return;
    renderer->frames().publish(std::move(computed));
    auto pose = renderer->head_poses().reclaim();
    if (!pose) pose = std::make_unique<Pose>();
    *pose = computed_pose;
    renderer->head_poses().publish(std::move(pose));
    const std::lock_guard lock(mutex);
    status.listener = computed_pose;
}

Player::Player(const Scene& scene, const SessionOptions& options)
    : state_(std::make_unique<State>(scene, options)) {}

Player::~Player() = default;

void Player::move_listener(const Pose& pose) {
    const std::lock_guard lock(state_->mutex);
    state_->wanted_pose = pose;
}

PlayStatus Player::status() {
    PlayStatus status;
    {
        const std::lock_guard lock(state_->mutex);
        if (state_->failure) std::rethrow_exception(state_->failure);
        status = state_->status;
    }
    status.time_s = state_->renderer->time_s();
    status.load = state_->device->load();
    status.worst_load = state_->device->worst_load();
    status.underruns = state_->device->underruns();
    status.peak = state_->renderer->take_peak();
    status.finished = status.time_s >= state_->timeline.end_s;
    if (!status.finished && !state_->device->active())
        throw AudioFailure("the output device \"" + state_->device->info().name +
                           "\" or its server is gone");
    return status;
}

const DeviceInfo& Player::device() const { return state_->device->info(); }

double Player::sample_rate_hz() const { return state_->rate_hz; }

const std::vector<std::string>& Player::warnings() const { return state_->warnings; }

}  // namespace aula
