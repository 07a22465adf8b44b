#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <utility>

namespace aula {

/// The sample time of what does not come.
inline constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

/// Changes of a target, each with its sample time.
template <typename Target>
class ChangeQueue {
 public:
    /// Adds a change after all others of its time.
    void add(std::int64_t at, std::function<void(Target&)> apply) {
        const auto later = std::upper_bound(
            changes_.begin(), changes_.end(), at,
            [](std::int64_t time, const auto& change) { return time < change.at; });
        changes_.insert(later, {at, std::move(apply)});
    }

    /// Applies and removes all changes up to a time.
    void apply(std::int64_t until, Target& target) {
        while (!changes_.empty() && changes_.front().at <= until) {
            changes_.front().apply(target);
            changes_.pop_front();
        }
    }

    /// The time of the next change; kNever if there is none.
    std::int64_t next() const { return changes_.empty() ? kNever : changes_.front().at; }

 private:
    struct Change {
        std::int64_t at = 0;
        std::function<void(Target&)> apply;
    };
    std::deque<Change> changes_;
};

}  // namespace aula
