#include "apps/aula/arguments/position_changes.h"

#include "aula/exception.h"

namespace aula {

void set_listener_position(Scene& scene, const Vec3& position) {
    scene.listener.pose = scene.listener.pose_at(0);
    scene.listener.pose.position = position;
    scene.listener.path.reset();
    scene.attach_sources();
}

void set_source_position(Scene& scene, const std::string& name, const Vec3& position) {
    std::string names;
    for (Source& source : scene.sources) {
        if (source.name == name) {
            source.set_pose(source.pose_at(0));
            source.position = position;
            source.path.reset();
            source.from_listener.reset();
            return;
        }
        names += (names.empty() ? "" : ", ") + source.name;
    }
    throw InputError("--source-position", "",
                     "the scene has no source \"" + name + "\"; expected one of " + names);
}

}  // namespace aula
