#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "apps/room/frames/signals.h"
#include "apps/window/model/test_signals.h"
#include "aula/devices/microphone.h"
#include "aula/engine/scene.h"

namespace aula {

/// The signals that the sources play: those of the scene, or others in their place. [one thread]
class SourceSignals {
 public:
    /// Makes a source play a signal.
    using Play = std::function<void(std::size_t source, std::shared_ptr<const Signal> signal)>;

    SourceSignals(double sample_rate_hz, Play play);

    /// Continues at another sample rate, for which the player has read the signals of the scene.
    void set_sample_rate(double sample_rate_hz);
    double sample_rate_hz() const { return rate_hz_; }

    /// Begins again with other sources, which play the signals of their scene.
    void restart(std::size_t source_count) { names_.assign(source_count, ""); }

    std::size_t source_count() const { return names_.size(); }

    /// Name of the signal that replaces the scene's; empty: none.
    const std::string& name(std::size_t source) const { return names_[source]; }

    /// Plays the scene's signal. Throws InputError; the source then keeps its signal.
    void play_own(const Scene& scene, std::size_t source);
    void play_test(std::size_t source, TestSignal signal);
    /// Plays a sound file, repeated. Throws InputError; the source then keeps its signal.
    void play_file(std::size_t source, const std::filesystem::path& file);
    void play_microphone(std::size_t source, const std::shared_ptr<Microphone>& microphone);

    /// The microphone that a source plays; null if no source plays one or its device is lost.
    std::shared_ptr<Microphone> open_microphone() const;

 private:
    void play(std::size_t source, std::shared_ptr<const Signal> signal, std::string name);

    double rate_hz_;
    Play play_;
    std::vector<std::string> names_;  ///< [source]
    std::weak_ptr<Microphone> microphone_;
};

}  // namespace aula
