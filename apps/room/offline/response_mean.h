#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "aula/engine/energy_response.h"

namespace aula {

/// The weighted mean of energy responses with the same bins. A discrete path counts as zero in
/// responses without it.
class ResponseMean {
 public:
    void add(const EnergyResponse& response, double weight = 1);
    void add(const ResponseMean& other);

    /// Requires at least one response.
    EnergyResponse value() const;

 private:
    using Sums = std::array<double, kBandCount>;
    struct PathSum {
        SoundPath path;
        Sums energy{};
    };

    void begin_like(const EnergyResponse& response);

    double weight_ = 0;
    EnergyResponse first_;
    std::vector<Sums> energy_;      ///< [bin]
    std::vector<Sums> directions_;  ///< [bin], the moments in the order of their declaration
    std::map<std::uint64_t, PathSum> paths_;
};

}  // namespace aula
