#include "apps/room/auralizer/source_register.h"

#include <algorithm>
#include <string>

#include "aula/exception.h"

namespace aula {

/// The largest number of sources that are present at a time from a beginning on.
std::size_t SourceRegister::max_present(const ChangeTime& from) const {
    const auto present = [&](const ChangeTime& time) {
        return static_cast<std::size_t>(
            std::count_if(entries_.begin(), entries_.end(), [&](const Entry& entry) {
                return entry.begin <= time && (!entry.end || time < *entry.end);
            }));
    };
    std::size_t max = present(from);
    for (const Entry& entry : entries_)
        if (entry.begin > from) max = std::max(max, present(entry.begin));
    return max;
}

SourceId SourceRegister::add(const ChangeTime& begin) {
    if (max_present(begin) >= max_sources_)
        throw InputError("auralizer: more than " + std::to_string(max_sources_) +
                         " sources; AuralizerOptions::max_sources is their number");
    const SourceId source{begin.of_before_frame ? ++last_of_before_frame_ : ++last_number_};
    entries_.push_back({source, begin, {}});
    return source;
}

void SourceRegister::restart(std::size_t sources, std::size_t max_sources) {
    entries_.clear();
    max_sources_ = max_sources;
    for (std::uint64_t number = 1; number <= sources; ++number)
        entries_.push_back({{number}, {}, {}});
    last_number_ = std::max<std::uint64_t>(last_number_, sources);
}

std::optional<ChangeTime> SourceRegister::remove(SourceId source, const ChangeTime& end) {
    const auto entry = std::find_if(entries_.begin(), entries_.end(),
                                    [&](const Entry& e) { return e.source == source && !e.end; });
    if (entry == entries_.end()) return std::nullopt;
    const ChangeTime time = std::max(end, entry->begin);
    entry->end = time;
    return time;
}

ChangeTime SourceRegister::after_beginning(SourceId source, const ChangeTime& time) const {
    for (const Entry& entry : entries_)
        if (entry.source == source) return std::max(time, entry.begin);
    return time;
}

std::vector<SourceId> SourceRegister::sources() const {
    std::vector<SourceId> sources;
    for (const Entry& entry : entries_)
        if (!entry.end) sources.push_back(entry.source);
    return sources;
}

void SourceRegister::forget(std::int64_t until) {
    std::erase_if(entries_,
                  [&](const Entry& entry) { return entry.end && entry.end->sample <= until; });
}

}  // namespace aula
