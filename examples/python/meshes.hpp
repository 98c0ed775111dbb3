/// @file
/// Meshes in Python: from arrays, from files, and as terrain.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "arrays.hpp"

#include <bristle/bristle.hpp>
#include <bristle/io/mesh_file.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <span>
#include <string>
#include <vector>

namespace bristle_python {

/// A surface of arrays: [vertex, 3] in m and [triangle, 3].
/// @throws as `points_of` and `whole_numbers_of`; InvalidArgument when it is no surface.
template <typename S>
[[nodiscard]] TriangleMesh<S> mesh_of(const py::object& vertices, const py::object& triangles) {
  TriangleMesh<S> mesh{points_of<S>("vertices", vertices), {}};
  const Array<std::int64_t> rows = whole_numbers_of("triangles", triangles);
  require_rows_of_three("triangles", rows);
  const auto count = static_cast<std::int64_t>(mesh.vertices.size());
  for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
    std::array<std::uint32_t, 3> triangle{};
    for (py::ssize_t k = 0; k < 3; ++k) {
      const std::int64_t vertex = rows.at(i, k);
      // A cast to 32 bits would make valid numbers of some that are not.
      if (vertex < 0 || vertex >= count) {
        throw InvalidArgument("triangles[" + std::to_string(i) + ", " + std::to_string(k) + "]",
                              std::to_string(vertex),
                              "must be from 0 to " + std::to_string(count - 1) + ", a vertex");
      }
      triangle[static_cast<std::size_t>(k)] = static_cast<std::uint32_t>(vertex);
    }
    mesh.triangles.push_back(triangle);
  }
  validate_surface(mesh);
  return mesh;
}

/// @param rows  Of three numbers each.
template <typename T, typename Row>
[[nodiscard]] Array<T> copied_rows(const std::vector<Row>& rows) {
  Array<T> result({rows.size(), std::size_t(3)});
  for (std::size_t i = 0; i < rows.size(); ++i) {
    std::copy_n(rows[i].data(), 3, result.mutable_data(static_cast<py::ssize_t>(i), 0));
  }
  return result;
}

template <typename S>
void bind_meshes(py::module_& m) {
  py::class_<TriangleMesh<S>>(
      m, "TriangleMesh",
      "Surface of triangles. As the shape of a body it is closed and faces outwards.")
      .def(py::init(&mesh_of<S>), "vertices"_a, "triangles"_a,
           "Surface of corners, [vertex, 3] in m, and of three numbers of corners a triangle, "
           "[triangle, 3] of whole numbers, counter-clockwise seen from outside.")
      .def_static(
          "load", [](const std::string& path) { return load_mesh<S>(path); }, "path"_a,
          "Mesh of an .stl or .obj file.")
      .def_property_readonly(
          "vertices", [](const TriangleMesh<S>& mesh) { return copied_rows<S>(mesh.vertices); },
          "[vertex, 3]: corners [m], copied.")
      .def_property_readonly(
          "triangles",
          [](const TriangleMesh<S>& mesh) { return copied_rows<std::uint32_t>(mesh.triangles); },
          "[triangle, 3]: numbers of corners, copied.");
  m.def(
      "height_field_mesh",
      [](const Eigen::Matrix<S, 2, 1>& size, const py::object& heights) {
        const Array<S> z = numbers_of<S>("heights", heights);
        if (z.ndim() != 2 || z.shape(0) < 2 || z.shape(1) < 2) {
          throw InvalidArgument("heights.shape", py::str(z.attr("shape")),
                                "must be (places along y, places along x), two each at least");
        }
        return height_field_mesh<S>(size,
                                    {static_cast<std::uint32_t>(z.shape(1) - 1),
                                     static_cast<std::uint32_t>(z.shape(0) - 1)},
                                    {z.data(), static_cast<std::size_t>(z.size())});
      },
      "size"_a, "heights"_a,
      "Open surface, facing +z, of heights over a rectangle around the origin: `size` is its whole "
      "sides [m] along x and y, and heights[j, i] is z [m] at the i-th of equally spaced places "
      "along x and the j-th along y. `extruded_mesh` makes ground of it.");
  m.def(
      "extruded_mesh",
      [](const TriangleMesh<S>& surface, const Vec3<S>& offset) {
        return extruded_mesh<S>(surface, offset);
      },
      "surface"_a, "offset"_a,
      "Solid between an open surface and its copy moved by `offset` [m], such as (0, 0, -0.5): "
      "ground half a metre thick. All of the surface faces against the offset.");
}

}  // namespace bristle_python
