/// @file
/// Shapes and sensors in Python.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/bristle.hpp>

#include <cstddef>
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <string>

namespace bristle_python {

namespace py = pybind11;
using namespace py::literals;
using namespace bristle;

/// @param m  Where it is added: `bristle` for double, `bristle.float32` for float.
template <typename S>
void bind_shapes(py::module_& m) {
  py::class_<Sphere<S>>(m, "Sphere")
      .def(py::init([](S radius) { return Sphere<S>{radius}; }), "radius"_a,
           "Ball of a radius [m].");
  py::class_<Box<S>>(m, "Box").def(py::init([](const Vec3<S>& half) { return Box<S>{half}; }),
                                   "half_extents"_a, "Cuboid of half edges [m].");
  py::class_<Capsule<S>>(m, "Capsule")
      .def(py::init([](S radius, S half) {
             return Capsule<S>{radius, half};
           }),
           "radius"_a, "half_length"_a, "Segment on z with a radius [m].");
  py::class_<Cylinder<S>>(m, "Cylinder")
      .def(py::init([](S radius, S half) {
             return Cylinder<S>{radius, half};
           }),
           "radius"_a, "half_length"_a, "Cylinder about z [m].");
  py::class_<HalfSpace<S>>(m, "HalfSpace")
      .def(py::init([](const Vec3<S>& n, S offset) {
             return HalfSpace<S>{n, offset};
           }),
           "normal"_a = Vec3<S>(0, 0, 1), "offset"_a = S(0),
           "All p with normal . p <= offset [m].");
  py::class_<TriangleMesh<S>>(m, "TriangleMesh")
      .def_static(
          "load", [](const std::string& path) { return load_mesh<S>(path); }, "path"_a,
          "Mesh of an .stl or .obj file.");
}

template <typename S>
void bind_sensors(py::module_& m) {
  py::class_<SensorParameters<S>>(m, "SensorParameters")
      .def(py::init([](S normal_stiffness, S normal_damping, S static_friction, S sliding_friction,
                       S breakaway_distance) {
             return SensorParameters<S>{normal_stiffness, normal_damping, static_friction,
                                        sliding_friction, breakaway_distance};
           }),
           "normal_stiffness"_a, "normal_damping"_a = S(0), "static_friction"_a = S(0),
           "sliding_friction"_a = S(0), "breakaway_distance"_a = S(1e-3),
           "K_N [N], K_D [N s], mu_S [1/m], mu_V [N s/m], sigma_a [m].")
      .def_readwrite("normal_stiffness", &SensorParameters<S>::normal_stiffness)
      .def_readwrite("normal_damping", &SensorParameters<S>::normal_damping)
      .def_readwrite("static_friction", &SensorParameters<S>::static_friction)
      .def_readwrite("sliding_friction", &SensorParameters<S>::sliding_friction)
      .def_readwrite("breakaway_distance", &SensorParameters<S>::breakaway_distance);
  py::class_<SensorLayout<S>>(m, "SensorLayout", "Rays in a body's frame.")
      .def(py::init<>())
      .def("__len__", [](const SensorLayout<S>& layout) { return layout.size(); })
      .def(
          "add",
          [](SensorLayout<S>& layout, const Vec3<S>& start, const Vec3<S>& along, S length) {
            layout.add(start, along, length);
          },
          "start"_a, "direction"_a, "length"_a, "Adds a ray [m], of a unit direction.");
  m.def(
      "sensor_grid",
      [](const Vec3<S>& center, const Vec3<S>& side_u, const Vec3<S>& side_v, std::size_t count_u,
         std::size_t count_v, S depth, S range) {
        return sensor_grid<S>({center, side_u, side_v, count_u, count_v, depth, range});
      },
      "center"_a, "side_u"_a, "side_v"_a, "count_u"_a, "count_v"_a, "depth"_a = S(0.005),
      "range"_a = S(0.010),
      "One sensor in each of count_u x count_v cells of a rectangle; rays along side_u x side_v.");
  py::class_<Tuning<S>>(m, "Tuning")
      .def(
          "parameters",
          [](const Tuning<S>& tuning, const SensorLayout<S>& layout) {
            return tuning.parameters(layout);
          },
          "sensors"_a, "Constants for a layout that carries the load alone.");
  m.def(
      "tuned_for",
      [](S friction, S creep, S load, S mass, S press) {
        return tuned_for<S>(
            {.friction = friction, .creep = creep, .load = load, .mass = mass, .press = press});
      },
      py::kw_only(), "friction"_a = S(0.8), "creep"_a = S(1e-3), "load"_a = S(10), "mass"_a = S(0),
      "press"_a = S(0.3), "Wants: friction [1], creep [m], load [N], moved mass [kg], press [1].");
}

}  // namespace bristle_python
