#include "engine/edges/direct_sound.h"

#include <algorithm>

namespace aula {

DirectSound::DirectSound(const RayScene& scene, float speed_of_sound_m_s)
    : edges_(scene), paths_(scene, edges_, double{speed_of_sound_m_s}) {}

std::vector<SpecularPath> DirectSound::find(const Vec3& source, const Vec3& listener,
                                            const Bands& attenuation_per_m) const {
    const std::vector<EdgePath> paths = paths_.find(source, listener, attenuation_per_m);
    if (paths.size() == 1 && paths[0].edges.empty()) return {};
    std::vector<SpecularPath> taps = paths_.taps(paths);
    std::stable_sort(taps.begin(), taps.end(), [](const SpecularPath& a, const SpecularPath& b) {
        return a.length_m < b.length_m;
    });
    return taps;
}

}  // namespace aula
