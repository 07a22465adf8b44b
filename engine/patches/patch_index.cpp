#include "engine/patches/patch_index.h"

#include <tsl/robin_map.h>

#include "engine/base/mix64.h"

namespace aula {

struct PatchIndex::Map : tsl::robin_map<std::uint64_t, std::uint32_t, MixHash> {};

PatchIndex::PatchIndex() : patch_of_key_(std::make_unique<Map>()) {}

PatchIndex::~PatchIndex() = default;

std::uint32_t PatchIndex::find(std::uint64_t key) const {
    std::uint32_t patch = kNone;
    find(std::span(&key, 1), std::span(&patch, 1));
    return patch;
}

void PatchIndex::find(std::span<const std::uint64_t> keys, std::span<std::uint32_t> patches) const {
    const Map& map = *patch_of_key_;
    for (std::size_t i = 0; i < patches.size(); ++i) {
        const auto found = map.find(keys[i]);
        patches[i] = found == map.end() ? kNone : found->second;
    }
}

std::uint32_t PatchIndex::use(std::uint64_t key) {
    const auto [entry, added] = patch_of_key_->try_emplace(key, kNone);
    if (added) {
        const std::uint32_t patch = new_number();
        entry.value() = patch;
        keys_[patch] = key;
        patch_of_row_[patch] = patch;
    }
    used_[entry->second] = moves_;
    return entry->second;
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
        used_.push_back(moves_);
        patch_of_row_.push_back(kNone);
        return number;
    }
    const std::uint32_t number = released_.back();
    released_.pop_back();
    return number;
}

void PatchIndex::release_unused(std::uint64_t keep,
                                const std::function<void(std::uint32_t)>& before) {
    for (std::size_t i = kept_; i < keys_.size(); ++i) {
        if (keys_[i] == kNoKey || moves_ - used_[i] <= keep) continue;
        const auto patch = static_cast<std::uint32_t>(i);
        before(patch);
        patch_of_key_->erase(keys_[i]);
        keys_[i] = kNoKey;
        released_.push_back(patch);
    }
}

}  // namespace aula
