#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "apps/room/auralizer/room_playback.h"
#include "aula/auralizer.h"

namespace aula {

/// The playback and the propagation thread, which builds it and computes its frames.
struct Auralizer::State {
    /// Throws InputError for wrong options.
    State(const Scene& scene, AuralizerOptions options);

    /// Builds the playback of a scene. [propagation thread]
    void build(const Scene& scene);

    /// Builds another scene, on the clock of this auralizer, with the HRTF of the present scene if
    /// the options have the same. `prepare` is called with it on the thread that builds it.
    std::shared_ptr<BuiltRoom> build_next(
        const Scene& scene, BuiltRoom::Sources sources, AuralizerOptions next,
        const std::function<void(BuiltRoom&)>& prepare = {}) const;

    /// Starts the frames.
    void begin();

    /// Ends the frames and the thread.
    void end();

    /// An object of the scene to which a command refers.
    struct FoundObject {
        RoomPlayback::NumberedScene of;
        std::size_t index = 0;
    };

    /// An object of the scene to which a command at a time refers, by its index or its name. Throws
    /// InputError if there is none.
    FoundObject find_object(std::size_t index, std::int64_t at) const;
    FoundObject find_object(const std::string& name, std::int64_t at) const;

    /// Moves an object. Throws InputError if it is not movable or the transform is not rigid.
    void set_transform(const FoundObject& object, const RigidTransform& transform, std::int64_t at);

    /// Assigns a material to an object, by the name of one of its scene or the library, or one that
    /// need not be in the scene. Throws InputError for an unknown name or wrong coefficients.
    void set_material(const FoundObject& object, const std::string& name, std::int64_t at);
    void set_material(const FoundObject& object, const Material& material, std::int64_t at);

    const AuralizerOptions options;
    std::mutex scene_mutex;  ///< set_scene() builds one scene at a time
    std::unique_ptr<RoomPlayback> playback;
    std::promise<void> built;    ///< the playback, or the error that prevents it
    std::promise<bool> started;  ///< whether frames are requested
    bool is_started = false;     ///< the promise has been fulfilled
    std::thread thread;
};

}  // namespace aula
