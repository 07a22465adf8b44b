#include "engine/cache/diffuse_path_cache.h"

#include <tsl/robin_map.h>

#include <cassert>
#include <cmath>
#include <deque>
#include <glm/geometric.hpp>
#include <vector>

namespace aula {

namespace {

/// Units of the sums, choices: they hold 2e9 1/m2, as of a million arrivals in each of a thousand
/// frames, and 9e12 m. The units are 100 dB below the energy of a ray that crosses a sphere of 1 m,
/// and a micrometre.
constexpr double kEnergyUnit = 0x1p-32;
constexpr double kLengthUnit_m = 0x1p-20;  // a micrometre

/// Slots of the table for each entry: it is at most half full.
constexpr std::size_t kSlotsPerEntry = 2;

struct IdentifierHash {
    // The identifier is already well mixed.
    std::size_t operator()(const PathIdentifier& path) const { return path.low; }
};

using Map = tsl::robin_map<PathIdentifier, DiffusePathCache::Entry, IdentifierHash>;

/// Adds (sign 1) or removes (sign -1) a ray's contribution, Eq. 3.4.
void change(DiffusePathCache::Entry& entry, const Arrival& arrival, std::int64_t sign) {
    entry.arrival_count += sign;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        entry.energy_sum[b] += sign * DiffusePathCache::to_fixed(arrival.energy[b]);
    }
    entry.length_sum += sign * std::llrint(double{arrival.length_m} / kLengthUnit_m);
    const float energy = arrival.energy.sum();
    for (int axis = 0; axis < 3; ++axis) {
        entry.intensity_sum[static_cast<std::size_t>(axis)] +=
            sign * DiffusePathCache::to_fixed(energy * arrival.direction[axis]);
    }
}

}  // namespace

struct DiffusePathCache::State {
    Readout readout;
    std::int64_t window_frames;
    std::size_t memory_bytes;
    Map entries;
    std::int64_t frame = 0;

    struct Frame {
        std::vector<Arrival> arrivals;
        std::int64_t rays = 0;
    };
    std::deque<Frame> window;  // windowed readout
    std::int64_t emitted_in_window = 0;
    std::size_t arrivals_in_window = 0;

    std::size_t bytes() const {
        return entries.size() * sizeof(Map::value_type) * kSlotsPerEntry +
               arrivals_in_window * sizeof(Arrival);
    }

    void forget_oldest_frame() {
        for (const Arrival& arrival : window.front().arrivals) {
            const auto entry = entries.find(arrival.path);
            assert(entry != entries.end());
            change(entry.value(), arrival, -1);
            if (entry->second.arrival_count == 0) entries.erase(entry);
        }
        emitted_in_window -= window.front().rays;
        arrivals_in_window -= window.front().arrivals.size();
        window.pop_front();
    }

    void expire_inserted_before(std::int64_t first_frame) {
        for (auto entry = entries.begin(); entry != entries.end();) {
            entry = entry->second.inserted_frame < first_frame ? entries.erase(entry)
                                                               : std::next(entry);
        }
    }

    void expire() {
        if (readout == Readout::windowed) {
            while (!window.empty() && (static_cast<std::int64_t>(window.size()) >= window_frames ||
                                       bytes() > memory_bytes)) {
                forget_oldest_frame();
            }
            return;
        }
        std::int64_t first_frame = frame - window_frames + 1;
        expire_inserted_before(first_frame);
        while (bytes() > memory_bytes && first_frame < frame) {
            expire_inserted_before(++first_frame);
        }
    }
};

DiffusePathCache::DiffusePathCache(Readout readout, int window_frames, std::size_t memory_bytes)
    : state_(std::make_unique<State>()) {
    assert(window_frames >= 1);
    state_->readout = readout;
    state_->window_frames = window_frames;
    state_->memory_bytes = memory_bytes;
}

DiffusePathCache::~DiffusePathCache() = default;

void DiffusePathCache::set_memory_bytes(std::size_t memory_bytes) {
    state_->memory_bytes = memory_bytes;
}

DiffusePathCache::DiffusePathCache(DiffusePathCache&&) noexcept = default;
DiffusePathCache& DiffusePathCache::operator=(DiffusePathCache&&) noexcept = default;

std::int64_t DiffusePathCache::to_fixed(float energy) {
    return std::llrint(double{energy} / kEnergyUnit);
}

void DiffusePathCache::add_frame(std::span<const Arrival> arrivals, int rays) {
    State& s = *state_;
    s.expire();
    for (const Arrival& arrival : arrivals) {
        const auto [entry, added] = s.entries.try_emplace(arrival.path);
        if (added) {
            entry.value().inserted_frame = s.frame;
            entry.value().image = arrival.image;
        }
        change(entry.value(), arrival, 1);
    }
    if (s.readout == Readout::windowed) {
        s.window.push_back({{arrivals.begin(), arrivals.end()}, rays});
        s.emitted_in_window += rays;
        s.arrivals_in_window += arrivals.size();
        // Differs from Eq. 3.2: every entry has the same divisor, the rays emitted in the window
        // whether or not they hit. Counting from the insertion divides by too few rays, because an
        // entry is inserted on a hit.
    } else {
        for (auto entry = s.entries.begin(); entry != s.entries.end(); ++entry) {
            entry.value().emitted_count += rays;
        }
    }
    ++s.frame;
}

void DiffusePathCache::add_to(const SpecularSound& images, EnergyResponse& response) const {
    const State& s = *state_;
    for (const auto& [path, entry] : s.entries) {
        if (images.has_tried(entry.image)) continue;
        const std::int64_t emitted =
            s.readout == Readout::windowed ? s.emitted_in_window : entry.emitted_count;
        // Eq. 3.3: the mean length determines the delay.
        const double length_m = static_cast<double>(entry.length_sum) * kLengthUnit_m /
                                static_cast<double>(entry.arrival_count);
        // Eq. 3.2: (eta / mu) (I-hat / eta) = I-hat / mu.
        const double scale = kEnergyUnit / static_cast<double>(emitted);
        const auto to_float = [&](std::int64_t sum) {
            return static_cast<float>(static_cast<double>(sum) * scale);
        };
        Bands energy;
        for (std::size_t b = 0; b < kBandCount; ++b) energy[b] = to_float(entry.energy_sum[b]);
        const auto& [x, y, z] = entry.intensity_sum;
        const Vec3 intensity(to_float(x), to_float(y), to_float(z));
        const float length = glm::length(intensity);
        // The arrivals of a path have nearly one direction.
        DirectionMoments directions;
        if (length > 0) directions = DirectionMoments::of(intensity / length) * energy.sum();
        directions.intensity = intensity;
        response.add(length_m, energy, directions);
    }
}

std::size_t DiffusePathCache::size() const { return state_->entries.size(); }

std::size_t DiffusePathCache::memory_bytes() const { return state_->bytes(); }

const DiffusePathCache::Entry* DiffusePathCache::find(const PathIdentifier& path) const {
    const auto entry = state_->entries.find(path);
    return entry == state_->entries.end() ? nullptr : &entry->second;
}

}  // namespace aula
