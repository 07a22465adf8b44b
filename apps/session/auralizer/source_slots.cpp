#include "apps/session/auralizer/source_slots.h"

#include <algorithm>
#include <limits>
#include <string>

#include "aula/exception.h"

namespace aula {

SourceSlots::Place SourceSlots::add(std::int64_t at) {
    std::size_t best = slots_.size();
    for (std::size_t s = 0; s < slots_.size(); ++s) {
        if (slots_[s].source.number != 0 || slots_[s].removed_at > at) continue;
        if (best == slots_.size() || slots_[s].rung_out_at < slots_[best].rung_out_at) best = s;
        if (slots_[best].rung_out_at <= at) break;
    }
    if (best == slots_.size())
        throw InputError("auralizer: more than " + std::to_string(slots_.size()) +
                         " sources; AuralizerOptions::max_sources is their number");
    const SourceId source{++last_number_};
    slots_[best].source = source;
    slots_[best].begins_at = at;
    sources_.push_back(source);
    return {source, best};
}

std::optional<SourceSlots::Removal> SourceSlots::remove(SourceId source, std::int64_t at,
                                                        std::int64_t tail_samples) {
    if (source.number == 0) return std::nullopt;
    const auto slot = std::find_if(slots_.begin(), slots_.end(),
                                   [&](const Slot& s) { return s.source == source; });
    if (slot == slots_.end()) return std::nullopt;
    const std::int64_t time = std::max(at, slot->begins_at);
    constexpr std::int64_t kLast = std::numeric_limits<std::int64_t>::max();
    const std::int64_t rung_out_at = time > kLast - tail_samples ? kLast : time + tail_samples;
    *slot = {.source = {}, .removed_at = time, .rung_out_at = rung_out_at};
    std::erase(sources_, source);
    return Removal{static_cast<std::size_t>(slot - slots_.begin()), time, rung_out_at};
}

std::int64_t SourceSlots::begins_at(SourceId source, std::int64_t otherwise) const {
    for (const Slot& slot : slots_)
        if (slot.source == source) return slot.begins_at;
    return otherwise;
}

}  // namespace aula
