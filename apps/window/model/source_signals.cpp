#include "apps/window/model/source_signals.h"

#include <utility>

namespace aula {

SourceSignals::SourceSignals(double sample_rate_hz, Play play)
    : rate_hz_(sample_rate_hz), play_(std::move(play)) {}

void SourceSignals::set_sample_rate(double sample_rate_hz) {
    rate_hz_ = sample_rate_hz;
    restart(source_count());
}

void SourceSignals::play(std::size_t source, std::shared_ptr<const Signal> signal,
                         std::string name) {
    play_(source, std::move(signal));
    names_[source] = std::move(name);
}

void SourceSignals::play_own(const Scene& scene, std::size_t source) {
    play(source, read_signal(scene, source, rate_hz_), "");
}

void SourceSignals::play_test(std::size_t source, TestSignal signal) {
    play(source, test_signal(signal, rate_hz_), test_signal_name(signal));
}

void SourceSignals::play_file(std::size_t source, const std::filesystem::path& file) {
    Source wanted;
    wanted.signal = Source::Signal::file;
    wanted.signal_file = file;
    wanted.loop = true;
    play(source, std::make_shared<const Signal>(wanted, rate_hz_, 0), file.filename().string());
}

void SourceSignals::play_microphone(std::size_t source,
                                    const std::shared_ptr<Microphone>& microphone) {
    microphone_ = microphone;
    const auto read = [microphone](std::int64_t position, std::span<float> out) {
        microphone->read(position, out);
    };
    play(source, std::make_shared<const Signal>(read), "microphone");
}

std::shared_ptr<Microphone> SourceSignals::open_microphone() const {
    auto open = microphone_.lock();
    return open && open->alive() ? open : nullptr;
}

}  // namespace aula
