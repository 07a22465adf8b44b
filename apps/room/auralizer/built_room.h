#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "apps/room/auralizer/frame_computer.h"
#include "apps/room/auralizer/sounding_room.h"
#include "audio/render/headphones.h"
#include "aula/auralizer.h"

namespace aula {

/// A scene that is built to be played: all of an auralizer that is exchanged with its scene.
struct BuiltRoom {
    /// Whose sources play in it.
    enum class Sources {
        of_scene,
        of_room_before,  ///< of another scene: those of this one only prepare the engine
    };

    /// Builds the engine and the renderers. `block`: the largest number of samples that the
    /// renderers process together. `hrtf`: that of the options, or null to read it. Throws
    /// InputError.
    BuiltRoom(const Scene& scene, Sources sources, const AuralizerOptions& options, int block,
              std::shared_ptr<const Hrtf> hrtf);

    /// How long the headphone filter rings after a sample, s.
    double headphones_s() const;

    /// See Auralizer::heard_length_s().
    double heard_length_s() const { return computer.response_length_s() + headphones_s(); }

    /// How long sources are audible after their signals have ended, samples.
    std::int64_t tail_samples(double longest_delay_s) const;

    const std::shared_ptr<const Scene> scene;
    const Sources sources;
    const std::size_t max_sources;
    const std::filesystem::path hrtf_file;
    const double rate_hz;
    const std::optional<int> rays;  ///< of the frames until Auralizer::set_rays(); none: by quality
    const std::shared_ptr<const HeadphoneFilter> headphones;  ///< null: none
    FrameComputer computer;
    std::unique_ptr<SoundingRoom> made;  ///< until the rendering thread has it
    SoundingRoom* const sounding;        ///< valid while frames of this scene are computed
};

}  // namespace aula
