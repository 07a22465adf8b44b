#include "engine/rays/ray_scene.h"

#if AULA_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>
#include <new>
#include <string>
#include <tuple>
#include <utility>

#include "aula/exception.h"
#include "engine/base/mix64.h"
#include "engine/base/tolerances.h"

namespace aula {

namespace {

constexpr std::size_t kPacket = 16;  // Embree has queries for 4, 8 and 16 rays

/// Static triangles that have the same corners as an earlier one, each with the first of them,
/// sorted. A ray would test all coincident triangles with the same result.
std::vector<RayScene::Twin> find_twins(const RayScene& scene) {
    struct Entry {
        std::size_t hash;
        std::uint32_t triangle;
    };
    const auto corners = [&](std::uint32_t triangle) {
        auto vertices = scene.triangle(triangle).vertices;
        std::sort(vertices.begin(), vertices.end(), [](const Vec3& a, const Vec3& b) {
            return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
        });
        return vertices;
    };
    std::vector<Entry> entries;
    for (std::uint32_t t = 0; t < scene.triangle_count(); ++t) {
        if (scene.moves(scene.triangle(t))) continue;
        std::size_t hash = 0;
        for (const Vec3& v : corners(t)) {
            for (const float x : {v.x, v.y, v.z}) hash = mix64(hash ^ std::hash<float>{}(x));
        }
        entries.push_back({hash, t});
    }
    std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
        return std::tie(a.hash, a.triangle) < std::tie(b.hash, b.triangle);
    });
    std::vector<RayScene::Twin> twins;
    std::uint32_t first = 0;
    for (std::size_t i = 0; i < entries.size(); ++i) {
        const bool repeats = i > 0 && entries[i].hash == entries[i - 1].hash &&
                             corners(entries[i].triangle) == corners(entries[i - 1].triangle);
        if (!repeats) first = entries[i].triangle;
        if (repeats) twins.push_back({first, entries[i].triangle});
    }
    std::sort(twins.begin(), twins.end());
    return twins;
}

RTCDevice new_device() {
    RTCDevice device = rtcNewDevice("threads=1,set_affinity=0,hugepages=1");
    if (!device && rtcGetDeviceError(nullptr) == RTC_ERROR_UNSUPPORTED_CPU)
        throw InputError(
            "the processor cannot trace rays; expected x86-64 with SSE2 or AArch64 with NEON");
    if (!device) throw std::bad_alloc();
    return device;
}

// Queries of incoherent rays, by the interface of Embree 4 or 3.
#if RTC_VERSION_MAJOR >= 4
RTCIntersectArguments incoherent_arguments() {
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.flags = RTC_RAY_QUERY_FLAG_INCOHERENT;
    return arguments;
}

void intersect_ray(RTCScene scene, RTCRayHit& ray) {
    RTCIntersectArguments arguments = incoherent_arguments();
    rtcIntersect1(scene, &ray, &arguments);
}

void intersect_packet(const int* valid, RTCScene scene, RTCRayHit16& packet) {
    RTCIntersectArguments arguments = incoherent_arguments();
    rtcIntersect16(valid, scene, &packet, &arguments);
}

void test_occlusion(RTCScene scene, RTCRay& ray) {
    RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.flags = RTC_RAY_QUERY_FLAG_INCOHERENT;
    rtcOccluded1(scene, &ray, &arguments);
}
#else
RTCIntersectContext incoherent_context() {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    return context;
}

void intersect_ray(RTCScene scene, RTCRayHit& ray) {
    RTCIntersectContext context = incoherent_context();
    rtcIntersect1(scene, &context, &ray);
}

void intersect_packet(const int* valid, RTCScene scene, RTCRayHit16& packet) {
    RTCIntersectContext context = incoherent_context();
    rtcIntersect16(valid, scene, &context, &packet);
}

void test_occlusion(RTCScene scene, RTCRay& ray) {
    RTCIntersectContext context = incoherent_context();
    rtcOccluded1(scene, &context, &ray);
}
#endif

}  // namespace

struct RayScene::Embree {
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;
    std::vector<std::uint32_t> first_triangle;  // of each geometry
    unsigned next_id = 0;

    Embree() : device(new_device()) { scene = rtcNewScene(device); }
    ~Embree() {
        rtcReleaseScene(scene);
        rtcReleaseDevice(device);
    }
    Embree(const Embree&) = delete;
    Embree& operator=(const Embree&) = delete;

    /// Adds an object, except the triangles for which `is_omitted` returns true.
    template <class IsOmitted>
    void add(const Object& object, const std::vector<Vec3>& world, const IsOmitted& is_omitted) {
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        rtcSetGeometryBuildQuality(
            geometry, object.moves() ? RTC_BUILD_QUALITY_LOW : RTC_BUILD_QUALITY_MEDIUM);
        auto* vertex_buffer = static_cast<float*>(
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                    3 * sizeof(float), world.size()));
        auto* index_buffer = static_cast<std::uint32_t*>(
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                    3 * sizeof(std::uint32_t), object.triangles.size()));
        copy_vertices(world, vertex_buffer);
        // Embree ignores triangles with invalid vertices.
        constexpr std::array<std::uint32_t, 3> kIgnored{~0U, ~0U, ~0U};
        for (std::size_t t = 0; t < object.triangles.size(); ++t) {
            const auto& triangle = is_omitted(t) ? kIgnored : object.triangles[t];
            index_buffer = std::copy(triangle.begin(), triangle.end(), index_buffer);
        }
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(scene, geometry, next_id++);
        rtcReleaseGeometry(geometry);
    }

    static void copy_vertices(const std::vector<Vec3>& world, float* buffer) {
        for (const Vec3& v : world) {
            *buffer++ = v.x;
            *buffer++ = v.y;
            *buffer++ = v.z;
        }
    }
};

RayScene::RayScene(const Scene& scene, double time_s)
    : embree_(std::make_unique<Embree>()),
      objects_(scene.objects),
      materials_(scene.materials),
      own_material_(scene.objects.size()) {
    bool any_moves = false;
    for (std::uint32_t o = 0; o < objects_.size(); ++o) {
        const Object& object = objects_[o];
        any_moves |= object.moves();
        embree_->first_triangle.push_back(static_cast<std::uint32_t>(triangles_.size()));
        world_vertices_.push_back(object.world_vertices(time_s));
        triangles_.resize(triangles_.size() + object.triangles.size());
        surfaces_.resize(triangles_.size());
        update_triangles(o);
    }
    twins_ = find_twins(*this);
    std::vector<bool> repeated(triangles_.size(), false);
    for (const Twin& twin : twins_) repeated[twin.omitted] = true;
    find_coplanar_faces(repeated);
    for (std::uint32_t o = 0; o < objects_.size(); ++o) {
        const Object& object = objects_[o];
        embree_->add(object, world_vertices_[o],
                     [&](std::size_t t) { return repeated[embree_->first_triangle[o] + t]; });
        if (!object.moves()) {
            // Only movable objects need their local vertices later.
            objects_[o].vertices.clear();
            objects_[o].vertices.shrink_to_fit();
        }
    }
    rtcSetSceneFlags(embree_->scene, any_moves ? RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_DYNAMIC
                                               : RTC_SCENE_FLAG_ROBUST);
    rtcCommitScene(embree_->scene);
    update_few();
    update_transmissions();
}

RayScene::~RayScene() = default;

void RayScene::update_triangles(std::uint32_t o) {
    const Object& object = objects_[o];
    const std::vector<Vec3>& vertices = world_vertices_[o];
    for (std::size_t t = 0; t < object.triangles.size(); ++t) {
        Triangle& triangle = triangles_[embree_->first_triangle[o] + t];
        for (std::size_t k = 0; k < 3; ++k) triangle.vertices[k] = vertices[object.triangles[t][k]];
        const Vec3 n = glm::cross(triangle.vertices[1] - triangle.vertices[0],
                                  triangle.vertices[2] - triangle.vertices[0]);
        const float twice_area = glm::length(n);
        triangle.normal = twice_area > 0 ? n / twice_area : Vec3(0);
        triangle.material = object.triangle_materials[t];
        triangle.object = o;
        surfaces_[embree_->first_triangle[o] + t] = {triangle.normal, triangle.material};
    }
}

void RayScene::update_few() {
    if (triangles_.size() > BruteForceIntersector::kMax) return;
    std::vector<BruteForceIntersector::Vertices> vertices;
    for (const Triangle& triangle : triangles_) vertices.push_back(triangle.vertices);
    for (const Twin& twin : twins_) vertices[twin.omitted].fill(vertices[twin.omitted][0]);
    few_.emplace(vertices);
}

void RayScene::update_transmissions() {
    transmissions_.clear();
    is_transmitting_.clear();
    for (const Material& material : materials_) {
        transmissions_.push_back(material.transmission());
        is_transmitting_.push_back(transmissions_.back().max() > 0 ? 1 : 0);
    }
    transmits_ = std::any_of(triangles_.begin(), triangles_.end(),
                             [&](const Triangle& t) { return transmits(t.material); });
    update_backing();
}

/// Finds the faces that an opaque one may back. All may be backed if an opaque object moves, or if
/// there are too many pairs to compare.
void RayScene::update_backing() {
    constexpr double kMostPairs = 2e6;  // a choice: bounds the time at loading
    may_be_backed_.assign(triangles_.size(), 0);
    if (!transmits_) return;
    std::vector<std::uint32_t> transmitting;
    std::vector<std::pair<Bounds, std::uint32_t>> opaque;
    bool opaque_moves = false;
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
        const Triangle& triangle = triangles_[t];
        if (transmits(triangle.material)) {
            transmitting.push_back(t);
        } else {
            Bounds bounds;
            bounds.add(triangle.vertices);
            opaque.emplace_back(Bounds{bounds.min - kBacking_m, bounds.max + kBacking_m}, t);
            opaque_moves |= moves(triangle);
        }
    }
    const double pairs =
        static_cast<double>(transmitting.size()) * static_cast<double>(opaque.size());
    for (const std::uint32_t t : transmitting) {
        const Triangle& triangle = triangles_[t];
        Bounds bounds;
        bounds.add(triangle.vertices);
        const auto backs = [&](const std::pair<Bounds, std::uint32_t>& other) {
            return glm::all(glm::lessThanEqual(other.first.min, bounds.max)) &&
                   glm::all(glm::lessThanEqual(bounds.min, other.first.max)) &&
                   std::abs(glm::dot(triangles_[other.second].normal, triangle.normal)) >=
                       kParallel;
        };
        may_be_backed_[t] = opaque_moves || moves(triangle) || pairs > kMostPairs ||
                            std::any_of(opaque.begin(), opaque.end(), backs);
    }
}

float RayScene::move(double time_s) {
    std::vector<RigidTransform> transforms;
    for (const Object& object : objects_) transforms.push_back(object.transform_at(time_s));
    return move(transforms);
}

float RayScene::move(std::span<const RigidTransform> transforms) {
    assert(transforms.size() == objects_.size());
    float moved_m = 0;
    for (std::uint32_t o = 0; o < objects_.size(); ++o) {
        if (!objects_[o].moves()) continue;
        std::vector<Vec3> world = objects_[o].world_vertices(transforms[o]);
        float object_moved_m = 0;
        for (std::size_t v = 0; v < world.size(); ++v) {
            object_moved_m =
                std::max(object_moved_m, glm::distance(world[v], world_vertices_[o][v]));
        }
        if (object_moved_m == 0) continue;
        moved_m = std::max(moved_m, object_moved_m);
        world_vertices_[o] = std::move(world);
        update_triangles(o);
        RTCGeometry geometry = rtcGetGeometry(embree_->scene, o);
        Embree::copy_vertices(world_vertices_[o], static_cast<float*>(rtcGetGeometryBufferData(
                                                      geometry, RTC_BUFFER_TYPE_VERTEX, 0)));
        rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
        rtcCommitGeometry(geometry);
    }
    if (moved_m > 0) {
        rtcCommitScene(embree_->scene);
        update_few();
    }
    return moved_m;
}

void RayScene::set_material(std::size_t object, const Material& material) {
    if (!own_material_[object]) {
        own_material_[object] = static_cast<std::uint32_t>(materials_.size());
        materials_.push_back(material);
    }
    const std::uint32_t index = *own_material_[object];
    materials_[index] = material;
    std::fill(objects_[object].triangle_materials.begin(),
              objects_[object].triangle_materials.end(), index);
    const std::uint32_t first = embree_->first_triangle[object];
    for (std::size_t t = 0; t < objects_[object].triangles.size(); ++t) {
        triangles_[first + t].material = index;
        surfaces_[first + t].material = index;
    }
    update_transmissions();
}

void RayScene::change_material(std::size_t index, const Material& material) {
    materials_[index] = material;
    update_transmissions();
}

void RayScene::intersect(std::span<const Ray> rays, std::span<Hit> hits) const {
    assert(rays.size() == hits.size());
    RayLanes lanes;
    HitLanes found;
    for (std::size_t first = 0; first < rays.size(); first += kLanes) {
        const std::size_t count = std::min(kLanes, rays.size() - first);
        for (std::size_t i = 0; i < count; ++i) {
            lanes.origin.set(i, rays[first + i].origin);
            lanes.direction.set(i, rays[first + i].direction);
            lanes.max_m[i] = rays[first + i].max_m;
        }
        intersect(lanes, count, found);
        for (std::size_t i = 0; i < count; ++i) {
            hits[first + i] = {found.triangle[i], found.distance_m[i], found.u[i], found.v[i]};
        }
    }
}

void RayScene::intersect(const RayLanes& rays, std::size_t count, HitLanes& hits) const {
    assert(count <= kLanes);
    if (few_) {
        few_->intersect(rays, count, hits);
        hear_smaller(count, hits);
        return;
    }
    for (std::size_t first = 0; first < count; first += kPacket) {
        alignas(64) RTCRayHit16 packet;
        alignas(64) int valid[kPacket];
        const auto take = [first](const std::array<float, kLanes>& from, float* to) {
            std::copy_n(from.data() + first, kPacket, to);
        };
        take(rays.origin.x, packet.ray.org_x);
        take(rays.origin.y, packet.ray.org_y);
        take(rays.origin.z, packet.ray.org_z);
        take(rays.direction.x, packet.ray.dir_x);
        take(rays.direction.y, packet.ray.dir_y);
        take(rays.direction.z, packet.ray.dir_z);
        take(rays.max_m, packet.ray.tfar);
        for (std::size_t i = 0; i < kPacket; ++i) {
            valid[i] = first + i < count ? -1 : 0;
            packet.ray.tnear[i] = 0;
            packet.ray.time[i] = 0;
            packet.ray.mask[i] = ~0U;
            packet.ray.id[i] = 0;
            packet.ray.flags[i] = 0;
            packet.hit.u[i] = packet.hit.v[i] = 0;  // kept where nothing is hit
            packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
            packet.hit.primID[i] = RTC_INVALID_GEOMETRY_ID;
            packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
        }
        intersect_packet(valid, embree_->scene, packet);
        for (std::size_t i = 0; i < kPacket; ++i) {
            const bool any = packet.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
            hits.triangle[first + i] =
                any ? embree_->first_triangle[packet.hit.geomID[i]] + packet.hit.primID[i]
                    : kNoTriangle;
            hits.distance_m[first + i] =
                any ? packet.ray.tfar[i] : std::numeric_limits<float>::infinity();
            hits.u[first + i] = packet.hit.u[i];
            hits.v[first + i] = packet.hit.v[i];
            // Prefetch: the hit surfaces are read next and, in large scenes, are scattered in
            // memory.
            if (any) __builtin_prefetch(&surfaces_[hits.triangle[first + i]]);
        }
    }
    hear_smaller(count, hits);
}

void RayScene::intersect_each(std::span<const Ray> rays, std::span<Hit> hits) const {
    assert(rays.size() == hits.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
        RTCRayHit query{};
        query.ray.org_x = rays[i].origin.x;
        query.ray.org_y = rays[i].origin.y;
        query.ray.org_z = rays[i].origin.z;
        query.ray.dir_x = rays[i].direction.x;
        query.ray.dir_y = rays[i].direction.y;
        query.ray.dir_z = rays[i].direction.z;
        query.ray.tfar = rays[i].max_m;
        query.ray.mask = ~0U;
        query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        intersect_ray(embree_->scene, query);
        hits[i] = query.hit.geomID == RTC_INVALID_GEOMETRY_ID
                      ? Hit{}
                      : heard({embree_->first_triangle[query.hit.geomID] + query.hit.primID,
                               query.ray.tfar, query.hit.u, query.hit.v});
    }
}

bool RayScene::visible(const Vec3& from, const Vec3& to, float shortened_m) const {
    const Vec3 offset = to - from;
    const float distance_m = glm::length(offset);
    if (distance_m <= 2 * shortened_m) return true;
    const Vec3 direction = offset / distance_m;
    RTCRay ray{};
    ray.org_x = from.x;
    ray.org_y = from.y;
    ray.org_z = from.z;
    ray.dir_x = direction.x;
    ray.dir_y = direction.y;
    ray.dir_z = direction.z;
    ray.tnear = shortened_m;
    ray.tfar = distance_m - shortened_m;
    ray.mask = ~0U;
    test_occlusion(embree_->scene, ray);
    return ray.tfar >= 0;
}

float RayScene::clear_m(const Vec3& point, float most_m) const {
    struct Search {
        const RayScene& scene;
        const Vec3& point;

        /// A lower bound of the distance to a triangle: to its plane or to its bounds.
        float least_m(std::uint32_t triangle) const {
            const Triangle& t = scene.triangle(triangle);
            Bounds bounds;
            bounds.add(t.vertices);
            const Vec3 outside = glm::max(glm::max(bounds.min - point, point - bounds.max), 0.0F);
            return std::max(glm::length(outside),
                            std::abs(glm::dot(point - t.vertices[0], t.normal)));
        }
    };
    Search search{*this, point};
    RTCPointQuery query{.x = point.x, .y = point.y, .z = point.z, .time = 0, .radius = most_m};
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(
        embree_->scene, &query, &context,
        [](RTCPointQueryFunctionArguments* arguments) {
            const Search& near = *static_cast<const Search*>(arguments->userPtr);
            const std::uint32_t first = near.scene.embree_->first_triangle[arguments->geomID];
            const float least_m = near.least_m(first + arguments->primID);
            const bool nearer = least_m < arguments->query->radius;
            if (nearer) arguments->query->radius = least_m;
            return nearer;
        },
        &search);
    return query.radius;
}

bool RayScene::has_opaque_twin(std::uint32_t triangle) const {
    auto twin = std::lower_bound(twins_.begin(), twins_.end(), Twin{triangle, 0});
    for (; twin != twins_.end() && twin->first == triangle; ++twin)
        if (!transmits(surfaces_[twin->omitted].material)) return true;
    return false;
}

bool RayScene::is_backed(const Vec3& point, std::uint32_t face) const {
    if (!may_be_backed_[face]) return false;
    struct Search {
        const RayScene& scene;
        const Vec3& point;
        const Vec3& normal;
        bool found = false;

        bool is_backing(std::uint32_t triangle) const {
            const Surface& surface = scene.surface(triangle);
            const std::uint32_t heard = scene.heard_at(triangle, point);
            if ((scene.transmits(scene.surface(heard).material) && !scene.has_opaque_twin(heard)) ||
                std::abs(glm::dot(surface.normal, normal)) < kParallel)
                return false;
            const auto& v = scene.triangle(triangle).vertices;
            const float off_m = glm::dot(point - v[0], surface.normal);
            if (std::abs(off_m) > kBacking_m) return false;
            const Vec3 in_plane = point - off_m * surface.normal;
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec3 side = glm::cross(v[(k + 1) % 3] - v[k], in_plane - v[k]);
                if (glm::dot(side, surface.normal) < 0) return false;
            }
            return true;
        }
    };
    Search search{*this, point, surfaces_[face].normal};
    RTCPointQuery query{.x = point.x, .y = point.y, .z = point.z, .time = 0, .radius = kBacking_m};
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(
        embree_->scene, &query, &context,
        [](RTCPointQueryFunctionArguments* arguments) {
            Search& found = *static_cast<Search*>(arguments->userPtr);
            const std::uint32_t first = found.scene.embree_->first_triangle[arguments->geomID];
            found.found |= found.is_backing(first + arguments->primID);
            return false;  // the radius stays
        },
        &search);
    return search.found;
}

Vec3 RayScene::facing_normal(const Hit& hit, const Vec3& ray_direction) const {
    const Vec3& normal = surfaces_[hit.triangle].normal;
    return glm::dot(normal, ray_direction) <= 0 ? normal : -normal;
}

Bounds RayScene::bounds() const {
    Bounds bounds;
    for (const Triangle& triangle : triangles_) bounds.add(triangle.vertices);
    return bounds;
}

Vec3 RayScene::point(const Hit& hit, const Vec3& ray_direction) const {
    const auto& v = triangles_[hit.triangle].vertices;
    const Vec3 on_surface = v[0] + hit.u * (v[1] - v[0]) + hit.v * (v[2] - v[0]);
    return on_surface + tolerances::kOffset_m * facing_normal(hit, ray_direction);
}

std::string ray_library() {
    const RTCDevice device = new_device();
    const auto number = [device](RTCDeviceProperty property) {
        return std::to_string(rtcGetDeviceProperty(device, property));
    };
    const std::string version = number(RTC_DEVICE_PROPERTY_VERSION_MAJOR) + "." +
                                number(RTC_DEVICE_PROPERTY_VERSION_MINOR) + "." +
                                number(RTC_DEVICE_PROPERTY_VERSION_PATCH);
    rtcReleaseDevice(device);
    return "Embree " + version;
}

}  // namespace aula
