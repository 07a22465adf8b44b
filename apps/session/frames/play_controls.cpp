#include "apps/session/frames/play_controls.h"

#include <algorithm>

namespace aula {

bool same_pose(const Pose& a, const Pose& b) {
    return a.position == b.position && a.yaw_rad == b.yaw_rad && a.pitch_rad == b.pitch_rad &&
           a.roll_rad == b.roll_rad;
}

bool PlayControls::heard(std::size_t s) const {
    const bool solos = std::any_of(sources.begin(), sources.end(),
                                   [](const SourceControl& source) { return source.solo; });
    return !source(s).muted && (!solos || source(s).solo);
}

PlayControls with_changes(PlayControls now, const PlayControls& from, const PlayControls& to) {
    const auto take = [&](auto member) {
        if (from.*member != to.*member) now.*member = to.*member;
    };
    take(&PlayControls::direct);
    take(&PlayControls::early);
    take(&PlayControls::late);
    take(&PlayControls::rays);
    take(&PlayControls::frame_share);
    take(&PlayControls::wet);
    const bool moved = from.listener && to.listener ? !same_pose(*from.listener, *to.listener)
                                                    : from.listener || to.listener;
    if (moved) now.listener = to.listener;
    now.sources.resize(std::max(now.sources.size(), to.sources.size()));
    for (std::size_t s = 0; s < to.sources.size(); ++s) {
        const SourceControl before = from.source(s);
        const SourceControl& after = to.sources[s];
        SourceControl& source = now.sources[s];
        if (before.gain_db != after.gain_db) source.gain_db = after.gain_db;
        if (before.muted != after.muted) source.muted = after.muted;
        if (before.solo != after.solo) source.solo = after.solo;
        if (before.position != after.position) source.position = after.position;
    }
    return now;
}

}  // namespace aula
