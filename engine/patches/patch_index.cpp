#include "engine/patches/patch_index.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <utility>

#include "engine/base/mix64.h"

namespace aula {

/// Patches by their keys: an open-addressing table with linear probing, at most half full. Each
/// reflection reads it once.
struct PatchIndex::Map {
    struct Slot {
        std::uint64_t key = kNoKey;
        std::uint32_t patch = kNone;
    };

    std::vector<Slot> slots = std::vector<Slot>(2);  // as many as a power of two
    std::size_t count = 0;

    std::size_t home(std::uint64_t key) const { return mix64(key) & (slots.size() - 1); }
    std::size_t next(std::size_t slot) const { return (slot + 1) & (slots.size() - 1); }

    /// The slot of a key, or the free one where it belongs. The search begins at `slot`.
    std::size_t search(std::uint64_t key, std::size_t slot) const {
        while (slots[slot].key != key && slots[slot].key != kNoKey) slot = next(slot);
        return slot;
    }

    /// The patch of a key, kNone if the key is new.
    std::uint32_t& at(std::uint64_t key) {
        std::size_t slot = search(key, home(key));
        if (slots[slot].key == kNoKey) {
            if (2 * ++count > slots.size()) {
                grow();
                slot = search(key, home(key));
            }
            slots[slot].key = key;
        }
        return slots[slot].patch;
    }

    void grow() {
        const std::vector<Slot> old = std::exchange(slots, std::vector<Slot>(2 * slots.size()));
        for (const Slot& s : old) {
            if (s.key != kNoKey) slots[search(s.key, home(s.key))] = s;
        }
    }

    /// Removes a key. Later keys of the same run move into the gap unless that is before their
    /// home.
    void erase(std::uint64_t key) {
        std::size_t gap = search(key, home(key));
        if (slots[gap].key == kNoKey) return;
        --count;
        const auto distance = [&](std::size_t from, std::size_t to) {
            return (to - from) & (slots.size() - 1);
        };
        for (std::size_t slot = next(gap); slots[slot].key != kNoKey; slot = next(slot)) {
            if (distance(home(slots[slot].key), slot) < distance(gap, slot)) continue;
            slots[gap] = slots[slot];
            gap = slot;
        }
        slots[gap] = {};
    }
};

PatchIndex::PatchIndex() : patch_of_key_(std::make_unique<Map>()) {}

PatchIndex::~PatchIndex() = default;

std::uint32_t PatchIndex::find(std::uint64_t key) const {
    const Map& map = *patch_of_key_;
    return map.slots[map.search(key, map.home(key))].patch;
}

void PatchIndex::find(std::span<const std::uint64_t> keys, std::span<std::uint32_t> patches) const {
    const Map& map = *patch_of_key_;
    // About as many lines as a core loads from memory at a time.
    constexpr std::size_t kTogether = 16;
    for (std::size_t first = 0; first < patches.size(); first += kTogether) {
        const std::size_t count = std::min(kTogether, patches.size() - first);
        // Prefetch: in large scenes the table is in main memory.
        std::array<std::size_t, kTogether> slots;
        for (std::size_t i = 0; i < count; ++i) {
            slots[i] = map.home(keys[first + i]);
            __builtin_prefetch(&map.slots[slots[i]]);
        }
        for (std::size_t i = 0; i < count; ++i) {
            patches[first + i] = map.slots[map.search(keys[first + i], slots[i])].patch;
        }
    }
}

std::uint32_t PatchIndex::use(std::uint64_t key) {
    assert(key != kNoKey);
    std::uint32_t& patch = patch_of_key_->at(key);
    if (patch == kNone) {
        patch = new_number();
        keys_[patch] = key;
        patch_of_row_[patch] = patch;
    }
    used_[patch] = 1;
    return patch;
}

std::uint32_t PatchIndex::add_side(std::uint32_t patch) {
    const std::uint32_t row = new_number();
    patch_of_row_[row] = patch;
    return row;
}

std::uint32_t PatchIndex::new_number() {
    if (released_.empty()) {
        const auto number = static_cast<std::uint32_t>(keys_.size());
        keys_.push_back(kNoKey);
        used_.push_back(0);
        patch_of_row_.push_back(kNone);
        return number;
    }
    const std::uint32_t number = released_.back();
    released_.pop_back();
    return number;
}

void PatchIndex::release_unused(const std::function<void(std::uint32_t)>& before) {
    for (std::size_t i = kept_; i < keys_.size(); ++i) {
        if (keys_[i] == kNoKey || used_[i]) continue;
        const auto patch = static_cast<std::uint32_t>(i);
        before(patch);
        patch_of_key_->erase(keys_[i]);
        keys_[i] = kNoKey;
        released_.push_back(patch);
    }
}

}  // namespace aula
