#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "aula/engine/bands.h"
#include "aula/engine/scene.h"

namespace aula {

namespace py = pybind11;

/// An array of the package aula, which has checked its shape: contiguous, of the type T.
template <typename T>
using Array = py::array_t<T, py::array::c_style | py::array::forcecast>;

inline Vec3 vector_of(const float* xyz) { return {xyz[0], xyz[1], xyz[2]}; }

inline Bands bands_of(const Array<float>& values) {
    Bands bands;
    std::copy_n(values.data(), kBandCount, bands.value.begin());
    return bands;
}

inline py::array_t<float> array_of(std::span<const float> values) {
    return py::array_t<float>(static_cast<py::ssize_t>(values.size()), values.data());
}

inline py::array_t<float> array_of(const Vec3& v) {
    return py::array_t<float>(3, std::vector<float>{v.x, v.y, v.z}.data());
}

/// A pose of [x, y, z, yaw, pitch, roll], m and rad.
inline Pose pose_of(const float* values) {
    return {.position = vector_of(values),
            .yaw_rad = values[3],
            .pitch_rad = values[4],
            .roll_rad = values[5]};
}

inline std::vector<float> values_of(const Pose& pose) {
    return {pose.position.x, pose.position.y, pose.position.z,
            pose.yaw_rad,    pose.pitch_rad,  pose.roll_rad};
}

}  // namespace aula
