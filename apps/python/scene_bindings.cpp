#include "apps/python/scene_bindings.h"

#include <pybind11/stl.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "apps/output/printable.h"
#include "apps/python/arrays.h"
#include "apps/room/auralizer/command_checks.h"
#include "apps/room/edit/scene_state.h"
#include "aula/engine/material_library.h"
#include "aula/engine/scene_file.h"
#include "aula/exception.h"
#include "engine/model/model_scene.h"

namespace aula {

namespace {

/// Times (K) in s, poses (K, 6) and whether it repeats.
using PathArrays = std::tuple<Array<double>, Array<float>, bool>;

std::optional<Trajectory> trajectory_of(const std::optional<PathArrays>& arrays) {
    if (!arrays) return std::nullopt;
    const auto& [times_s, poses, loop] = *arrays;
    Trajectory path;
    path.loop = loop;
    for (py::ssize_t k = 0; k < times_s.size(); ++k)
        path.points.push_back({times_s.data()[k], pose_of(poses.data() + 6 * k)});
    return path;
}

py::object arrays_of(const std::optional<Trajectory>& path) {
    if (!path) return py::none();
    const auto count = static_cast<py::ssize_t>(path->points.size());
    py::array_t<double> times_s(count);
    py::array_t<float> poses({count, py::ssize_t{6}});
    for (py::ssize_t k = 0; k < count; ++k) {
        const Trajectory::Keyframe& point = path->points[static_cast<std::size_t>(k)];
        times_s.mutable_data()[k] = point.time_s;
        const std::vector<float> pose = values_of(point.pose);
        std::copy(pose.begin(), pose.end(), poses.mutable_data() + 6 * k);
    }
    return py::make_tuple(times_s, poses, path->loop);
}

Source make_source(const std::string& name, const Array<float>& pose,
                   const std::string& directivity, float gain_db, bool loop,
                   const std::optional<PathArrays>& path) {
    Source source;
    source.name = name;
    source.set_pose(pose_of(pose.data()));
    set_directivity(source, directivity);
    source.gain_db = gain_db;
    source.loop = loop;
    source.path = trajectory_of(path);
    // A file without a name: the source is silent unless it is given a signal.
    source.signal = Source::Signal::file;
    return source;
}

Material make_material(const std::string& name, const Array<float>& absorption,
                       const Array<float>& scattering,
                       const std::optional<Array<float>>& sound_reduction_db) {
    Material material{
        .name = name, .absorption = bands_of(absorption), .scattering = bands_of(scattering)};
    if (sound_reduction_db) material.sound_reduction_db = bands_of(*sound_reduction_db);
    for (std::size_t band = 0; band < kBandCount; ++band)
        if (material.sound_reduction_db && material.transmits_too_much(band))
            throw InputError("sound_reduction_db: transmits more energy than is absorbed at " +
                             std::to_string(std::lround(kBandCentres_hz[band])) +
                             " Hz; expected a higher index or absorption");
    check_material(material);
    return material;
}

Scene mesh_scene(const Array<float>& vertices, const Array<std::uint32_t>& triangles,
                 const Array<std::uint32_t>& triangle_materials,
                 const std::vector<Material>& materials) {
    Scene scene;
    scene.materials = materials;
    Object& object = scene.objects.emplace_back();
    object.name = "mesh";
    for (py::ssize_t v = 0; v < vertices.shape(0); ++v)
        object.vertices.push_back(vector_of(vertices.data() + 3 * v));
    for (py::ssize_t t = 0; t < triangles.shape(0); ++t) {
        const std::uint32_t* const corners = triangles.data() + 3 * t;
        object.triangles.push_back({corners[0], corners[1], corners[2]});
    }
    object.triangle_materials.assign(triangle_materials.data(),
                                     triangle_materials.data() + triangle_materials.size());
    check_geometry(scene);
    return scene;
}

/// All vertices in world axes at time 0, triangles and their materials.
py::tuple geometry_of(const Scene& scene) {
    std::vector<float> vertices;
    std::vector<std::uint32_t> triangles, materials;
    for (const Object& object : scene.objects) {
        const auto first = static_cast<std::uint32_t>(vertices.size() / 3);
        for (const Vec3& v : object.world_vertices(0.0))
            vertices.insert(vertices.end(), {v.x, v.y, v.z});
        for (const auto& triangle : object.triangles)
            for (const std::uint32_t corner : triangle) triangles.push_back(first + corner);
        materials.insert(materials.end(), object.triangle_materials.begin(),
                         object.triangle_materials.end());
    }
    const auto rows = [](std::size_t count) {
        return std::vector<py::ssize_t>{static_cast<py::ssize_t>(count / 3), 3};
    };
    return py::make_tuple(
        py::array_t<float>(rows(vertices.size()), vertices.data()),
        py::array_t<std::uint32_t>(rows(triangles.size()), triangles.data()),
        py::array_t<std::uint32_t>(static_cast<py::ssize_t>(materials.size()), materials.data()));
}

py::dict simulation_dict(const Simulation& s) {
    using py::literals::operator""_a;
    return py::dict("estimator"_a = estimator_name(s.estimator),
                    "quality"_a = quality_name(s.quality), "rays"_a = s.rays, "order"_a = s.order,
                    "specular_order"_a = s.specular_order, "specular"_a = s.specular,
                    "direct"_a = s.direct, "diffraction_order"_a = s.diffraction_order,
                    "transmission"_a = s.transmission, "response_time_s"_a = s.response_time_s,
                    "patch_size_m"_a = s.patch_size_m, "listener_radius_m"_a = s.listener_radius_m,
                    "frame_rate_hz"_a = s.frame_rate_hz, "ir_length_s"_a = s.ir_length_s,
                    "seed"_a = s.seed, "memory_mb"_a = s.memory_mb, "waves_hz"_a = s.waves_hz);
}

/// Assigns a setting from Python. Throws InputError, py::cast_error for another type.
void set_setting(Simulation& s, const std::string& name, const py::handle& value) {
    const auto assign = [&]<typename T>(T& setting) { setting = value.cast<T>(); };
    if (name == "estimator") {
        const auto estimator = estimator_from_name(value.cast<std::string>());
        if (!estimator) throw InputError("estimator: expected pt, dpc-published, dpc or patch");
        s.estimator = *estimator;
    } else if (name == "quality") {
        const auto quality = quality_from_name(value.cast<std::string>());
        if (!quality) throw InputError("quality: expected draft, normal or fine");
        s.quality = *quality;
    } else if (name == "rays") {
        assign(s.rays);
    } else if (name == "order") {
        assign(s.order);
    } else if (name == "specular_order") {
        assign(s.specular_order);
    } else if (name == "specular") {
        assign(s.specular);
    } else if (name == "direct") {
        assign(s.direct);
    } else if (name == "diffraction_order") {
        assign(s.diffraction_order);
    } else if (name == "transmission") {
        assign(s.transmission);
    } else if (name == "response_time_s") {
        assign(s.response_time_s);
    } else if (name == "patch_size_m") {
        assign(s.patch_size_m);
    } else if (name == "listener_radius_m") {
        assign(s.listener_radius_m);
    } else if (name == "frame_rate_hz") {
        assign(s.frame_rate_hz);
    } else if (name == "ir_length_s") {
        if (py::isinstance<py::str>(value) && value.cast<std::string>() == "auto")
            s.ir_length_s.reset();
        else
            assign(s.ir_length_s);
    } else if (name == "seed") {
        assign(s.seed);
    } else if (name == "memory_mb") {
        assign(s.memory_mb);
    } else if (name == "waves_hz") {
        assign(s.waves_hz);
    } else {
        throw InputError("there is no setting \"" + name + "\" of the simulation");
    }
}

void set_simulation(Simulation& simulation, const py::dict& settings) {
    for (const auto& [key, value] : settings) {
        const auto name = key.cast<std::string>();
        try {
            set_setting(simulation, name, value);
        } catch (const py::cast_error&) {
            throw InputError(name + ": " + py::repr(value).cast<std::string>() +
                             " is not of the type or in the range of this setting");
        }
    }
    simulation.check();
}

void bind_materials(py::module_& module) {
    py::class_<Material>(module, "Material")
        .def(py::init(&make_material))
        .def_readonly("name", &Material::name)
        .def_property_readonly("absorption",
                               [](const Material& m) { return array_of(m.absorption.value); })
        .def_property_readonly("scattering",
                               [](const Material& m) { return array_of(m.scattering.value); })
        .def_property_readonly("sound_reduction_db", [](const Material& m) -> py::object {
            return m.sound_reduction_db ? py::object(array_of(m.sound_reduction_db->value))
                                        : py::object(py::none());
        });
    module.def("library", [] {
        std::vector<Material> materials;
        for (const LibraryMaterial& known : material_library()) materials.push_back(known.material);
        return materials;
    });
}

void bind_sources(py::module_& module) {
    py::class_<Source>(module, "Source")
        .def(py::init(&make_source))
        .def_readonly("name", &Source::name)
        .def_property_readonly("pose",
                               [](const Source& s) { return array_of(values_of(s.pose_at(0))); })
        .def_property_readonly("directivity", &directivity_name)
        .def_readonly("gain_db", &Source::gain_db)
        .def_readonly("loop", &Source::loop)
        .def_property_readonly("path", [](const Source& s) { return arrays_of(s.path); })
        .def_property_readonly("signal_file",
                               [](const Source& s) { return s.signal_file.string(); });
    module.def("directivities", &Directivity::names);
}

/// A scene that is read without the interpreter's lock, and its warnings.
std::pair<SharedScene, std::vector<std::string>> loaded_by(
    const std::function<LoadedScene()>& load) {
    std::optional<LoadedScene> loaded;
    {
        const py::gil_scoped_release released;
        loaded = load();
    }
    return {SharedScene(std::move(loaded->scene)), printable_lines(std::move(loaded->warnings))};
}

}  // namespace

void bind_scenes(py::module_& module) {
    bind_materials(module);
    bind_sources(module);
    py::class_<SharedScene>(module, "Scene")
        .def_static(
            "load",
            [](const std::string& file) { return loaded_by([&] { return load_scene(file); }); })
        .def_static(
            "load_model",
            [](const std::string& file, std::optional<double> scale, std::optional<bool> y_is_up) {
                return loaded_by([&] { return load_model(file, {scale, y_is_up}); });
            })
        .def_static(
            "parse",
            [](const std::string& text, const std::string& name) {
                return SharedScene(parse_scene(text, name, std::filesystem::current_path()).scene);
            })
        .def_static(
            "mesh",
            [](const Array<float>& vertices, const Array<std::uint32_t>& triangles,
               const Array<std::uint32_t>& triangle_materials,
               const std::vector<Material>& materials) {
                return SharedScene(mesh_scene(vertices, triangles, triangle_materials, materials));
            })
        .def_static("from_state",
                    [](const std::string& state) { return SharedScene(scene_from_state(state)); })
        .def("copy", [](const SharedScene& scene) { return scene; })
        .def("state", [](const SharedScene& scene,
                         bool threads) { return py::bytes(scene_state(*scene.get(), threads)); })
        .def("geometry", [](const SharedScene& scene) { return geometry_of(*scene.get()); })
        .def("materials", [](const SharedScene& scene) { return scene.get()->materials; })
        .def("set_material",
             [](SharedScene& scene, const std::string& name, Material material) {
                 scene.change([&](Scene& changed) {
                     material.name = name;
                     for (Material& known : changed.materials) {
                         if (known.name != name) continue;
                         known = material;
                         return;
                     }
                     throw InputError("there is no material \"" + name + "\" in the scene");
                 });
             })
        .def("sources", [](const SharedScene& scene) { return scene.get()->sources; })
        .def("set_sources",
             [](SharedScene& scene, const std::vector<Source>& sources) {
                 scene.change([&](Scene& changed) { changed.sources = sources; });
             })
        .def("listener",
             [](const SharedScene& scene) {
                 const Listener& listener = scene.get()->listener;
                 return py::make_tuple(array_of(values_of(listener.pose_at(0))),
                                       arrays_of(listener.path));
             })
        .def("set_listener",
             [](SharedScene& scene, const Array<float>& pose,
                const std::optional<PathArrays>& path) {
                 scene.change([&](Scene& changed) {
                     changed.listener = {pose_of(pose.data()), trajectory_of(path)};
                     changed.attach_sources();
                 });
             })
        .def("medium",
             [](const SharedScene& scene) {
                 const Medium& m = scene.get()->medium;
                 return py::make_tuple(m.temperature_c, m.humidity_percent, m.pressure_kpa,
                                       m.air_absorption);
             })
        .def("set_medium",
             [](SharedScene& scene, float temperature_c, float humidity_percent, float pressure_kpa,
                bool air_absorption) {
                 scene.change([&](Scene& changed) {
                     changed.medium = {temperature_c, humidity_percent, pressure_kpa,
                                       air_absorption};
                 });
             })
        .def("air",
             [](const SharedScene& scene) {
                 const Medium& m = scene.get()->medium;
                 return py::make_tuple(m.speed_of_sound_m_s(),
                                       array_of(m.attenuation_per_m().value));
             })
        .def("simulation",
             [](const SharedScene& scene) { return simulation_dict(scene.get()->simulation); })
        .def("set_simulation", [](SharedScene& scene, const py::dict& settings) {
            scene.change([&](Scene& changed) { set_simulation(changed.simulation, settings); });
        });
}

}  // namespace aula
