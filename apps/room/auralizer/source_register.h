#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "apps/room/auralizer/change_queue.h"
#include "aula/auralizer.h"

namespace aula {

/// Numbers the sources of an auralizer and records when they begin and end.
class SourceRegister {
 public:
    explicit SourceRegister(std::size_t max_sources) : max_sources_(max_sources) {}

    /// Adds a source. Those of before_frame are numbered apart, so that no number depends on the
    /// timing of threads. Throws InputError if more than the most sources would be present.
    SourceId add(const ChangeTime& begin);

    /// All sources are the first ones, from 1 on, of another scene.
    void restart(std::size_t sources, std::size_t max_sources);

    /// Removes a source, after it has begun. Returns when it ends; empty if it was not present.
    std::optional<ChangeTime> remove(SourceId source, const ChangeTime& end);

    /// The later of a time and a source's beginning.
    ChangeTime after_beginning(SourceId source, const ChangeTime& time) const;

    /// The sources that are not removed, in the order of their addition.
    std::vector<SourceId> sources() const;

    /// Drops the sources that have ended by a sample. All later times must be after it.
    void forget(std::int64_t until);

 private:
    struct Entry {
        SourceId source;
        ChangeTime begin;
        std::optional<ChangeTime> end;
    };

    std::size_t max_present(const ChangeTime& from) const;

    std::size_t max_sources_;
    std::vector<Entry> entries_;
    std::uint64_t last_number_ = 0;
    std::uint64_t last_of_before_frame_ = std::uint64_t{1} << 32;
};

}  // namespace aula
