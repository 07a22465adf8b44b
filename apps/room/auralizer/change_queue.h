#pragma once

#include <algorithm>
#include <compare>
#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <utility>

namespace aula {

/// The sample time of a change that never comes.
inline constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

/// When a change takes effect. At one sample the changes of before_frame follow all others,
/// whichever thread was first.
struct ChangeTime {
    std::int64_t sample = 0;
    bool of_before_frame = false;
    friend auto operator<=>(const ChangeTime&, const ChangeTime&) = default;
};

/// Changes of a target in the order of their times; those of one time in the order of their calls.
template <typename Target>
class ChangeQueue {
 public:
    void add(const ChangeTime& time, std::function<void(Target&)> apply) {
        const auto later = std::upper_bound(
            changes_.begin(), changes_.end(), time,
            [](const ChangeTime& added, const Change& change) { return added < change.time; });
        changes_.insert(later, {time, std::move(apply)});
    }

    /// Applies and removes all changes up to a sample.
    void apply(std::int64_t until, Target& target) {
        while (!changes_.empty() && changes_.front().time.sample <= until) {
            changes_.front().apply(target);
            changes_.pop_front();
        }
    }

    /// The sample of the next change; kNever if there is none.
    std::int64_t next() const { return changes_.empty() ? kNever : changes_.front().time.sample; }

 private:
    struct Change {
        ChangeTime time;
        std::function<void(Target&)> apply;
    };
    std::deque<Change> changes_;
};

}  // namespace aula
