#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "aula/auralizer.h"

namespace aula {

/// The sources of an auralizer and the slots of the renderer that they occupy.
class SourceSlots {
 public:
    explicit SourceSlots(std::size_t slots) : slots_(slots) {}

    struct Place {
        SourceId source;
        std::size_t slot = 0;
    };

    /// Adds a source in a slot that is free at a time, or in that of the source that has rung out
    /// the most. Throws InputError if there is none.
    Place add(std::int64_t at);

    struct Removal {
        std::size_t slot = 0;
        std::int64_t at = 0;           ///< not before the source begins
        std::int64_t rung_out_at = 0;  ///< `tail_samples` later
    };

    /// Removes a source; empty if it is not present.
    std::optional<Removal> remove(SourceId source, std::int64_t at, std::int64_t tail_samples);

    /// The sources that are present, in the order of their addition.
    const std::vector<SourceId>& sources() const { return sources_; }

    /// When a source begins; `otherwise` if it is not present.
    std::int64_t begins_at(SourceId source, std::int64_t otherwise) const;

 private:
    struct Slot {
        SourceId source;               ///< that plays in it
        std::int64_t begins_at = 0;    ///< of the source
        std::int64_t removed_at = 0;   ///< of the source before
        std::int64_t rung_out_at = 0;  ///< likewise
    };

    std::vector<Slot> slots_;
    std::vector<SourceId> sources_;
    std::uint64_t last_number_ = 0;
};

}  // namespace aula
