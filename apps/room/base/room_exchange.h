#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "audio/base/mailbox.h"
#include "audio/dsp/fade.h"
#include "aula/audio/realtime.h"

namespace aula {

/// Exchanges one room that plays for another: the input of the next one fades in while that of the
/// present one fades out and then rings out. The weights of all inputs add up to one, so that each
/// sample is rendered once in total, without a click. `Source` provides rooms, and takes those that
/// have rung out: take() and give_back() of a Mailbox. A room has tail_samples(): how long it is
/// heard after its input has ended. No function waits or allocates unless one of the room, of the
/// source or of the caller does. [rendering thread, except the constructor and tail_samples()]
template <typename Room, typename Source = Mailbox<Room>>
class RoomExchange {
 public:
    /// Rooms that ring out at the same time. A further one fades the oldest out.
    static constexpr std::size_t kMaxRinging = 2;

    /// Rooms that are held at the same time: with the present one, and one that waits or fades out.
    static constexpr std::size_t kMaxHeld = kMaxRinging + 2;

    /// Duration of the fade between inputs, s: a choice, five periods of 100 Hz. Beyond 200 Hz from
    /// a tone it leaves less than -60 dB (`test_room "A tone has no clicks while the scene*" -s`).
    static constexpr double kFade_s = 0.05;

    /// `block`: the largest number of samples of render().
    RoomExchange(Source& rooms, double sample_rate_hz, int block)
        : rooms_(rooms),
          first_fade_(static_cast<std::size_t>(std::lround(kFade_s * sample_rate_hz))),
          ringing_(kMaxHeld - 1, Ringing(first_fade_)),
          weights_(static_cast<std::size_t>(block)),
          output_weights_(weights_),
          playing_weights_(weights_) {}

    ~RoomExchange() { clear(); }
    RoomExchange(const RoomExchange&) = delete;
    RoomExchange& operator=(const RoomExchange&) = delete;

    /// Begins the next room if there is one. It waits until fewer than kMaxRinging ring out.
    /// `fades_in(room)`: whether its input fades in; called before it begins.
    template <typename FadesIn>
    void advance(FadesIn&& fades_in) noexcept {
        if (waiting_ == nullptr) waiting_ = rooms_.take();
        if (waiting_ == nullptr) return;
        if (ringing_count() == kMaxRinging) return end(oldest());
        Room& next = *std::exchange(waiting_, nullptr);
        begin(next, fades_in(next));
    }
    /// The input of the first room does not fade in.
    void advance() noexcept {
        advance([this](Room&) noexcept AULA_NONBLOCKING { return playing_ != nullptr; });
    }

    /// Begins the next room, which there is, without a wait: the oldest one fades out meanwhile. Of
    /// more than one that fade out the oldest ends at once.
    void advance_now(bool fades_in) noexcept {
        if (ringing_count() == ringing_.size()) give_back(oldest());
        if (ringing_count() == kMaxRinging) end(oldest());
        begin(*rooms_.take(), fades_in);
    }

    /// The room that plays; null before the first one.
    Room* playing() const noexcept AULA_NONBLOCKING { return playing_; }

    /// Calls a function for each room that sounds.
    template <typename Visit>
    void for_each(Visit&& visit) noexcept {
        if (playing_ != nullptr) visit(*playing_);
        for (const Ringing& ringing : ringing_)
            if (ringing.room != nullptr) visit(*ringing.room);
    }

    /// Calls visit(room, input weights, output weights) for each room that sounds, first for the
    /// one that plays. Weights are a factor for each sample; empty: 1.
    template <typename Visit>
    void render(int samples, Visit&& visit) noexcept {
        const auto count = static_cast<std::size_t>(samples);
        if (playing_ != nullptr) visit(*playing_, playing_weights(count), std::span<float>());
        for (const Ringing& ringing : ringing_) {
            if (ringing.room == nullptr) continue;
            const std::span<float> input = std::span(weights_).first(count);
            for (std::size_t n = 0; n < count; ++n) input[n] = ringing.weight(n);
            const std::span<float> output =
                std::span(output_weights_).first(ringing.ends ? count : 0);
            for (std::size_t n = 0; n < output.size(); ++n)
                output[n] = 1 - ringing.output.weight(n);
            visit(*ringing.room, input, output);
        }
        advance_fades(samples);
    }

    /// How long the rooms are heard after their inputs have ended. [any thread]
    std::int64_t tail_samples() const noexcept AULA_NONBLOCKING { return tail_samples_.load(); }

    /// Gives all rooms back.
    void clear() noexcept {
        for (Ringing& ringing : ringing_)
            if (ringing.room != nullptr) give_back(ringing);
        for (Room** const room : {&playing_, &waiting_})
            if (*room != nullptr) rooms_.give_back(std::exchange(*room, nullptr));
    }

 private:
    /// A room that rings out.
    struct Ringing {
        explicit Ringing(const Fade& fade) : input(fade), output(fade) {}

        float weight(std::size_t n) const noexcept AULA_NONBLOCKING {
            return begin_weight * (1 - input.weight(n));
        }

        Room* room = nullptr;  ///< null: free for another one
        std::uint64_t number = 0;
        float begin_weight = 1;  ///< of the input when it began to fade out
        bool shared = true;      ///< its weights and those of the room that plays add up to one
        Fade input;
        Fade output;
        bool ends = false;           ///< the output fades out
        std::int64_t remaining = 0;  ///< samples
    };

    std::size_t ringing_count() const noexcept AULA_NONBLOCKING {
        std::size_t count = 0;
        for (const Ringing& ringing : ringing_) count += ringing.room != nullptr ? 1 : 0;
        return count;
    }

    Ringing& oldest() noexcept AULA_NONBLOCKING {
        Ringing* oldest = nullptr;
        for (Ringing& ringing : ringing_)
            if (ringing.room != nullptr && (oldest == nullptr || ringing.number < oldest->number))
                oldest = &ringing;
        return *oldest;
    }

    void give_back(Ringing& ringing) noexcept {
        rooms_.give_back(std::exchange(ringing.room, nullptr));
    }

    static void end(Ringing& ringing) noexcept AULA_NONBLOCKING {
        if (std::exchange(ringing.ends, true)) return;
        ringing.output.start();
    }

    /// The weight of the room that plays, `n` samples later.
    float playing_weight(std::size_t n) const noexcept AULA_NONBLOCKING {
        float weight = first_fade_.weight(n);
        for (const Ringing& ringing : ringing_)
            if (ringing.room != nullptr && ringing.shared) weight -= ringing.weight(n);
        return weight;
    }

    /// Empty without a fade.
    std::span<float> playing_weights(std::size_t count) noexcept AULA_NONBLOCKING {
        bool fades = !first_fade_.done();
        for (const Ringing& ringing : ringing_)
            fades = fades || (ringing.room != nullptr && ringing.shared && !ringing.input.done());
        const std::span<float> weights = std::span(playing_weights_).first(fades ? count : 0);
        for (std::size_t n = 0; n < weights.size(); ++n) weights[n] = playing_weight(n);
        return weights;
    }

    void begin(Room& next, bool fades_in) noexcept {
        if (playing_ != nullptr) {
            ring(*playing_, playing_weight(0));
            for (Ringing& ringing : ringing_) ringing.shared = ringing.shared && fades_in;
        } else if (fades_in) {
            first_fade_.start();
        }
        playing_ = &next;
    }

    /// Lets a room ring out: beyond its tail for the fade of its input, and as long again for the
    /// decay of the filters.
    void ring(Room& room, float weight) noexcept {
        for (Ringing& ringing : ringing_) {
            if (ringing.room != nullptr) continue;
            ringing.room = &room;
            ringing.number = ++last_number_;
            ringing.begin_weight = weight;
            ringing.shared = true;
            ringing.ends = false;
            ringing.input.start();
            ringing.remaining =
                room.tail_samples() + 2 * static_cast<std::int64_t>(ringing.input.remaining());
            return;
        }
    }

    void advance_fades(int samples) noexcept {
        first_fade_.advance(static_cast<std::size_t>(samples));
        std::int64_t longest = playing_ != nullptr ? playing_->tail_samples() : 0;
        for (Ringing& ringing : ringing_) {
            if (ringing.room == nullptr) continue;
            ringing.input.advance(static_cast<std::size_t>(samples));
            ringing.output.advance(static_cast<std::size_t>(samples));
            ringing.remaining -= samples;
            if (ringing.ends && ringing.output.done()) {
                give_back(ringing);
                continue;
            }
            if (ringing.remaining <= 0) end(ringing);
            longest = std::max(longest, ringing.remaining);
        }
        tail_samples_.store(longest, std::memory_order_relaxed);
    }

    Source& rooms_;
    Room* playing_ = nullptr;
    Room* waiting_ = nullptr;  ///< until fewer ring out
    Fade first_fade_;          ///< of a room without one before it
    std::vector<Ringing> ringing_;
    std::uint64_t last_number_ = 0;
    std::vector<float> weights_;
    std::vector<float> output_weights_;
    std::vector<float> playing_weights_;
    std::atomic<std::int64_t> tail_samples_ = 0;
};

}  // namespace aula
