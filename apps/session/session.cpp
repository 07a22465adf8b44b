#include "apps/session/session.h"

#include <chrono>
#include <thread>

#include "apps/session/live/player.h"
#include "apps/session/offline/offline.h"

namespace aula {

std::shared_ptr<const Hrtf> hrtf_for(const SessionOptions& options, double sample_rate_hz) {
    if (options.output != OutputFormat::binaural) return nullptr;
    return std::make_shared<const Hrtf>(options.hrtf, sample_rate_hz);
}

Session::Session(Scene scene, SessionOptions options)
    : scene_(std::move(scene)), options_(std::move(options)) {}

bool Session::render(const std::filesystem::path& file, const Progress& progress) {
    return render_offline(scene_, options_, file, progress, warnings_);
}

void Session::play() {
    Player player(scene_, options_);
    warnings_ = player.warnings();
    while (!player.status().finished) std::this_thread::sleep_for(std::chrono::milliseconds(50));
}

}  // namespace aula
