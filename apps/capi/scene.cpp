#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "apps/capi/handles.h"
#include "apps/capi/result.h"
#include "apps/room/auralizer/command_checks.h"
#include "aula/engine/scene_file.h"
#include "process/files.h"

namespace aula {

namespace {

constexpr float kLargestCoordinate_m = 1e6F;

/// "object 3" or its name in quotes.
std::string label(std::size_t index, const std::string& name) {
    return name.empty() ? "object " + std::to_string(index) : '"' + name + '"';
}

std::vector<Vec3> read_vertices(const float* coordinates, std::size_t count,
                                const std::string& object) {
    std::vector<Vec3> vertices(count);
    for (std::size_t v = 0; v < count; ++v) {
        const float* const xyz = coordinates + 3 * v;
        // The comparison also fails for NaN.
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (!(std::abs(xyz[axis]) <= kLargestCoordinate_m))
                throw InputError(object + ": vertex " + std::to_string(v) +
                                 " is not usable; expected coordinates from -1e6 to 1e6 m");
        vertices[v] = {xyz[0], xyz[1], xyz[2]};
    }
    return vertices;
}

std::vector<std::array<std::uint32_t, 3>> read_triangles(const std::uint32_t* indices,
                                                         std::size_t count, std::size_t vertices,
                                                         const std::string& object) {
    std::vector<std::array<std::uint32_t, 3>> triangles(count);
    for (std::size_t t = 0; t < count; ++t) {
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const std::uint32_t index = indices[3 * t + corner];
            if (index >= vertices)
                throw InputError(object + ": triangle " + std::to_string(t) + " has the vertex " +
                                 std::to_string(index) + "; expected an index below " +
                                 std::to_string(vertices));
            triangles[t][corner] = index;
        }
    }
    return triangles;
}

/// The index of an element by its name. Throws InputError if there is none.
template <typename T>
std::size_t index_of(const std::vector<T>& elements, const std::string& name, const char* kind) {
    const auto found = std::find_if(elements.begin(), elements.end(), [&](const T& element) {
        return !name.empty() && element.name == name;
    });
    if (found == elements.end())
        throw InputError(std::string("the scene has no ") + kind + " \"" + name + '"');
    return static_cast<std::size_t>(found - elements.begin());
}

/// Throws InputError if an element has that name, unless it is empty.
template <typename T>
void check_new(const std::vector<T>& elements, const std::string& name, const char* a_kind) {
    for (const T& element : elements)
        if (!name.empty() && element.name == name)
            throw InputError(std::string("the scene already has ") + a_kind + " \"" + name +
                             "\"; expected another name");
}

Bands read_bands(const float* values) {
    Bands bands;
    for (std::size_t b = 0; b < kBandCount; ++b) bands[b] = values[b];
    return bands;
}

}  // namespace

Pose pose_of(const aula_pose* pose) {
    const aula_pose& given = not_null(pose, "pose");
    return {.position = {given.position[0], given.position[1], given.position[2]},
            .yaw_rad = given.yaw_rad,
            .pitch_rad = given.pitch_rad,
            .roll_rad = given.roll_rad};
}

Directivity directivity_of(const char* name) {
    const std::string wanted = name != nullptr ? name : "omni";
    const auto found = Directivity::find(wanted);
    if (!found) throw InputError("there is no directivity \"" + wanted + '"');
    return *found;
}

}  // namespace aula

static_assert(AULA_BANDS == aula::kBandCount);

int aula_scene_load(const char* file, aula_scene** scene) {
    return aula::result_of([&] {
        aula::not_null(scene, "scene") = nullptr;
        auto loaded = aula::load_scene(aula::utf8_path(&aula::not_null(file, "file")));
        *scene = new aula_scene{std::move(loaded.scene)};
    });
}

int aula_scene_create(aula_scene** scene) {
    return aula::result_of([&] {
        aula::not_null(scene, "scene") = nullptr;
        *scene = new aula_scene{};
    });
}

void aula_scene_destroy(aula_scene* scene) { delete scene; }

int aula_scene_add_material(aula_scene* scene, const char* name, const float* absorption,
                            const float* scattering, const float* sound_reduction_db) {
    return aula::result_of([&] {
        auto& materials = aula::not_null(scene, "scene").scene.materials;
        aula::Material material;
        material.name = &aula::not_null(name, "name");
        if (material.name.empty()) throw aula::InputError("the name of a material is empty");
        aula::check_new(materials, material.name, "a material");
        material.absorption = aula::read_bands(&aula::not_null(absorption, "absorption"));
        material.scattering = aula::read_bands(&aula::not_null(scattering, "scattering"));
        if (sound_reduction_db != nullptr)
            material.sound_reduction_db = aula::read_bands(sound_reduction_db);
        aula::check_material(material);
        materials.push_back(std::move(material));
    });
}

int aula_scene_add_object(aula_scene* scene, const char* name, const float* vertices,
                          size_t vertex_count, const uint32_t* triangles, size_t triangle_count,
                          const char* material, int movable, size_t* object) {
    return aula::result_of([&] {
        aula::Scene& changed = aula::not_null(scene, "scene").scene;
        aula::not_null(vertices, "vertices");
        aula::not_null(triangles, "triangles");
        const std::string named = name != nullptr ? name : "";
        const std::string text = aula::label(changed.objects.size(), named);
        if (triangle_count == 0)
            throw aula::InputError(text + " has no triangle; expected at least one");
        aula::check_new(changed.objects, named, "an object");
        const std::size_t index =
            changed.add_object(aula::read_vertices(vertices, vertex_count, text),
                               aula::read_triangles(triangles, triangle_count, vertex_count, text),
                               &aula::not_null(material, "material"), named);
        changed.objects[index].movable = movable != 0;
        if (object != nullptr) *object = index;
    });
}

int aula_scene_find_object(const aula_scene* scene, const char* name, size_t* object) {
    return aula::result_of([&] {
        const auto& objects = aula::not_null(scene, "scene").scene.objects;
        aula::not_null(object, "object") =
            aula::index_of(objects, &aula::not_null(name, "name"), "object");
    });
}

int aula_scene_make_movable(aula_scene* scene, size_t object) {
    return aula::result_of([&] {
        auto& objects = aula::not_null(scene, "scene").scene.objects;
        if (object >= objects.size())
            throw aula::InputError("the scene has no object " + std::to_string(object));
        objects[object].movable = true;
    });
}

int aula_scene_find_source(const aula_scene* scene, const char* name, aula_source* source) {
    return aula::result_of([&] {
        aula::not_null(source, "source") = 0;
        const auto& sources = aula::not_null(scene, "scene").scene.sources;
        *source = 1 + aula::index_of(sources, &aula::not_null(name, "name"), "source");
    });
}

const char* aula_scene_source_name(const aula_scene* scene, aula_source source) {
    if (scene == nullptr || source < 1 || source > scene->scene.sources.size()) return nullptr;
    return scene->scene.sources[source - 1].name.c_str();
}

int aula_scene_add_source(aula_scene* scene, const char* name, const aula_pose* pose,
                          const char* directivity, float gain_db, aula_source* source) {
    return aula::result_of([&] {
        aula::not_null(source, "source") = 0;
        auto& sources = aula::not_null(scene, "scene").scene.sources;
        aula::Source added;
        added.name = &aula::not_null(name, "name");
        if (added.name.empty()) throw aula::InputError("the name of a source is empty");
        aula::check_new(sources, added.name, "a source");
        const aula::Pose place = aula::pose_of(pose);
        aula::check_pose(place);
        aula::check_gain(gain_db);
        added.set_pose(place);
        added.directivity = aula::directivity_of(directivity);
        added.gain_db = gain_db;
        sources.push_back(std::move(added));
        *source = sources.size();
    });
}

int aula_scene_set_listener(aula_scene* scene, const aula_pose* pose) {
    return aula::result_of([&] {
        aula::Scene& changed = aula::not_null(scene, "scene").scene;
        const aula::Pose place = aula::pose_of(pose);
        aula::check_pose(place);
        changed.listener = {.pose = place, .path = {}};
        changed.attach_sources();
    });
}
