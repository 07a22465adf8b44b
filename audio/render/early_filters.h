#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "audio/base/aligned.h"
#include "audio/dsp/band_filter.h"

namespace aula {

/// Filters of the early paths of the reverberation, which are many: designs would take most of the
/// time of a frame. Gains re the greatest and lengths are rounded, which changes a filter by less
/// than -45 dB, so that a path keeps it while the listener walks a decimetre. A filter does not
/// depend on those that are kept.
/// [propagation thread]
class EarlyFilters {
 public:
    /// `designer` has air if `has_air`, and outlives this. Filters have `margin` zeros at both
    /// ends.
    EarlyFilters(BandFilterDesigner& designer, bool has_air, std::size_t margin,
                 std::size_t sources);

    /// The filter of gains as BandFilterDesigner::design has them, not all 0, re the greatest, up
    /// to the sample from which on it has less than -80 dB of its energy. Valid until the next
    /// frame.
    std::span<const float> filter(std::size_t source, const std::array<float, 8>& gains,
                                  double length_m);

    /// Forgets the filters that the source has not used since the last call.
    void next_frame(std::size_t source);

 private:
    using Key = std::array<std::int16_t, 9>;  ///< steps of gains, of the length
    using Filters = std::map<Key, AlignedVector<float>>;

    AlignedVector<float> design(const Key& key);

    BandFilterDesigner& designer_;
    bool has_air_;
    std::size_t margin_;
    AlignedVector<float> whole_;
    std::vector<Filters> used_;    ///< [source]
    std::vector<Filters> before_;  ///< [source] used in the frame before only
};

}  // namespace aula
