#include "engine/edges/direct_sound.h"

#include <algorithm>
#include <cmath>

namespace aula {

DirectSound::DirectSound(const RayScene& scene, float speed_of_sound_m_s)
    : edges_(scene), paths_(scene, edges_, double{speed_of_sound_m_s}) {}

std::vector<SpecularPath> DirectSound::find(const Vec3& source, const Vec3& listener,
                                            const OrientedDirectivity& directivity,
                                            const Bands& attenuation_per_m) const {
    std::vector<EdgePath> paths = paths_.find(source, listener, attenuation_per_m);
    if (paths.size() == 1 && paths[0].edges.empty()) return {};
    if (!directivity.is_omnidirectional()) {
        for (EdgePath& path : paths) {
            const Bands factor = directivity.factor(path.departure);
            for (std::size_t b = 0; b < kBandCount; ++b)
                path.field[b] *= std::sqrt(double{factor[b]});
        }
    }
    std::vector<SpecularPath> taps = paths_.taps(paths);
    std::stable_sort(taps.begin(), taps.end(), [](const SpecularPath& a, const SpecularPath& b) {
        return a.length_m < b.length_m;
    });
    return taps;
}

}  // namespace aula
