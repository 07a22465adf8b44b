#include "apps/godot/room_geometry.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace aula::godot {
namespace {

// Mesh.ARRAY_VERTEX, ARRAY_INDEX and PRIMITIVE_TRIANGLES.
constexpr std::int64_t kVertexArray = 0, kIndexArray = 12, kTriangles = 3;

/// What holds for the nodes below a node.
struct Inherited {
    const MaterialResource* body_material = nullptr;
    std::uint64_t moving_body = 0;
};

class Collector {
 public:
    Collector(Object room, const MaterialResource* material)
        : room_(room), material_(material), frame_(rigid(global_transform(room))) {}

    void visit_children(Object node, Inherited inherited) {
        const Value children = node.call("get_children", true);
        const std::int64_t count = children.size();
        for (std::int64_t i = 0; i < count; ++i) visit(children.element(i).to_object(), inherited);
    }

    RoomGeometry geometry;

 private:
    void visit(Object node, Inherited inherited) {
        if (const auto* body = instance_of<BodyNode>(node)) {
            if (!body->audible) return;
            if (const MaterialResource* own = body->material()) inherited.body_material = own;
            if (body->moving) inherited.moving_body = node.id();
        } else if (node.is_class("AulaRoom")) {
            return;
        } else if (node.is_class("MeshInstance3D")) {
            add_mesh(node, node.call("get_mesh"), global_transform(node), true, inherited);
        } else if (node.is_class("CSGShape3D") && node.call("is_root_shape").to_bool()) {
            const Value meshes = node.call("get_meshes");
            if (meshes.size() == 2)
                add_mesh(node, meshes.element(1), global_transform(node), false, inherited);
        }
        visit_children(node, inherited);
    }

    void add_mesh(Object node, const Value& mesh, const Transform& global, bool has_overrides,
                  const Inherited& inherited) {
        const Object resource = mesh.to_object();
        if (!resource) return;
        const std::int64_t count = resource.call("get_surface_count").to_int();
        for (std::int64_t s = 0; s < count; ++s) {
            if (resource.is_class("ArrayMesh") &&
                resource.call("surface_get_primitive_type", s).to_int() != kTriangles)
                continue;
            const Value visible = has_overrides ? node.call("get_active_material", s)
                                                : resource.call("surface_get_material", s);
            RoomMesh added = surface(resource.call("surface_get_arrays", s), global);
            if (added.triangles.empty()) continue;
            added.name = room_.call("get_path_to", node).to_string() + " " + std::to_string(s);
            added.material = material_name(visible.to_object(), inherited.body_material);
            added.body = inherited.moving_body;
            geometry.meshes.push_back(std::move(added));
        }
    }

    RoomMesh surface(const Value& arrays, const Transform& global) const {
        RoomMesh mesh;
        const Transform to_room = relative(global, frame_);
        const auto vertices = arrays.element(kVertexArray).to_vectors();
        for (const Vector& vertex : vertices) {
            const Vector point = to_aula(to_room(vertex));
            mesh.vertices.insert(mesh.vertices.end(), point.begin(), point.end());
        }
        const std::vector<std::int32_t> indices = arrays.element(kIndexArray).to_integers();
        if (indices.empty()) {
            for (std::uint32_t i = 0; i < vertices.size(); ++i) mesh.triangles.push_back(i);
        } else {
            for (const std::int32_t index : indices)
                mesh.triangles.push_back(static_cast<std::uint32_t>(index));
        }
        mesh.triangles.resize(mesh.triangles.size() / 3 * 3);
        return mesh;
    }

    std::string material_name(Object visible, const MaterialResource* of_body) {
        if (of_body == nullptr && visible) {
            std::string name = visible.call("get_name").to_string();
            if (is_preset(name)) return name;
        }
        const MaterialResource* material = of_body != nullptr ? of_body : material_;
        if (material == nullptr) return "plaster";
        std::string name = material->name();
        const bool is_known =
            std::any_of(geometry.materials.begin(), geometry.materials.end(),
                        [&](const RoomMaterial& known) { return known.name == name; });
        if (material->preset.empty() && !is_known)
            geometry.materials.push_back(
                {name, material->absorption, material->scattering, material->sound_reduction_db});
        return name;
    }

    Object room_;
    const MaterialResource* material_;
    Transform frame_;
};

}  // namespace

Transform global_transform(Object node) {
    return node.call("get_global_transform").to<Transform>(GDEXTENSION_VARIANT_TYPE_TRANSFORM3D);
}

RoomGeometry collect_geometry(Object room, const MaterialResource* material) {
    Collector collector(room, material);
    collector.visit_children(room, {});
    return std::move(collector.geometry);
}

}  // namespace aula::godot
