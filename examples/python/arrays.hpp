/// @file
/// Arrays of numpy, quaternions in their order, and the names that all of the binding uses.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/types.hpp>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <span>

namespace bristle_python {

namespace py = pybind11;
using namespace py::literals;
using namespace bristle;

/// An array in C order of exactly this type: what is given out, and what is written into.
template <typename T>
using Array = py::array_t<T, py::array::c_style>;
/// Anything that numpy makes such an array of.
template <typename T>
using ArrayLike = py::array_t<T, py::array::c_style | py::array::forcecast>;

template <typename T>
[[nodiscard]] Array<T> copied(std::span<const T> values) {
  return Array<T>(static_cast<py::ssize_t>(values.size()), values.data());
}

/// Quaternions are x, y, z, w in Python.
template <typename S>
[[nodiscard]] Quat<S> rotation_of(const Eigen::Matrix<S, 4, 1>& xyzw) {
  return Quat<S>(xyzw[3], xyzw[0], xyzw[1], xyzw[2]);
}

}  // namespace bristle_python
