#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <vector>

namespace aula {

/// The numbers of a grid's rows: those of the patches, which are found by the key of their cell,
/// and those of the patches' sides. New rows reuse released numbers. [propagation thread;
/// const functions may run on several threads]
class PatchIndex {
 public:
    /// No row.
    static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

    PatchIndex();
    ~PatchIndex();

    /// The patch of a key, or kNone.
    std::uint32_t find(std::uint64_t key) const;

    /// The patches of several keys, as many as `patches`.
    void find(std::span<const std::uint64_t> keys, std::span<std::uint32_t> patches) const;

    /// The patch of a key, added if there is none. It is then used in the present move.
    std::uint32_t use(std::uint64_t key);

    /// Adds a row for a side of a patch.
    std::uint32_t add_side(std::uint32_t patch);

    /// Releases the row of a side.
    void release_side(std::uint32_t row) { released_.push_back(row); }

    /// Keeps all present patches permanently. Patches that are added later can be released.
    void keep_present() { kept_ = keys_.size(); }

    /// Begins a move, in which no patch is used yet.
    void begin_move() { used_.assign(keys_.size(), 0); }

    /// Releases the patches that are not used in the present move. Calls `before(patch)` for each
    /// of them.
    void release_unused(const std::function<void(std::uint32_t)>& before);

    /// The patch of a row: the row itself, or that of which it is a side.
    std::uint32_t patch_of(std::uint32_t row) const { return patch_of_row_[row]; }

    /// The key of a patch that is not released.
    std::uint64_t key(std::uint32_t patch) const { return keys_[patch]; }

    /// All numbers are below size(); released ones are included.
    std::size_t size() const { return keys_.size(); }

 private:
    struct Map;
    /// Of a direction that no key has.
    static constexpr std::uint64_t kNoKey = ~0ULL;

    std::uint32_t new_number();

    std::unique_ptr<Map> patch_of_key_;
    std::vector<std::uint64_t> keys_;  ///< [row]; kNoKey: a side or released
    std::vector<char> used_;           ///< [patch] in the present move
    std::vector<std::uint32_t> patch_of_row_;
    std::vector<std::uint32_t> released_;  ///< numbers, the last of which is reused first
    std::size_t kept_ = 0;                 ///< patches that are never released
};

}  // namespace aula
