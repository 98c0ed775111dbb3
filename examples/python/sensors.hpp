/// @file
/// Shapes, but for meshes, and sensors in Python.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "arrays.hpp"

#include <bristle/bristle.hpp>

#include <cstddef>
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

namespace bristle_python {

/// @param m  Where it is added: `bristle` for double, `bristle.float32` for float.
template <typename S>
void bind_shapes(py::module_& m) {
  py::class_<Sphere<S>>(m, "Sphere", "Ball.")
      .def(py::init([](S radius) { return Sphere<S>{radius}; }), "radius"_a,
           "Ball of a radius [m].");
  py::class_<Box<S>>(m, "Box", "Cuboid.")
      .def(py::init([](const Vec3<S>& half) { return Box<S>{half}; }), "half_extents"_a,
           "Cuboid of half edges [m].");
  py::class_<Capsule<S>>(m, "Capsule", "Segment on z with a radius.")
      .def(py::init([](S radius, S half) {
             return Capsule<S>{radius, half};
           }),
           "radius"_a, "half_length"_a, "Segment on z with a radius [m].");
  py::class_<Cylinder<S>>(m, "Cylinder", "Cylinder about z.")
      .def(py::init([](S radius, S half) {
             return Cylinder<S>{radius, half};
           }),
           "radius"_a, "half_length"_a, "Cylinder about z [m].");
  py::class_<Cone<S>>(m, "Cone", "Cone about z, its apex up.")
      .def(py::init([](S radius, S half) {
             return Cone<S>{radius, half};
           }),
           "radius"_a, "half_length"_a, "Cone about z [m], twice `half_length` high.");
  py::class_<Ellipsoid<S>>(m, "Ellipsoid", "Ellipsoid along the axes.")
      .def(py::init([](const Vec3<S>& radii) { return Ellipsoid<S>{radii}; }), "radii"_a,
           "Ellipsoid of three radii [m].");
  py::class_<ConvexHull<S>>(m, "ConvexHull", "Convex solid.")
      .def(py::init([](const py::object& points) {
             return convex_hull<S>(points_of<S>("points", points));
           }),
           "points"_a, "Hull of points: [point, 3] in m.");
  py::class_<HalfSpace<S>>(m, "HalfSpace", "All points on one side of a plane.")
      .def(py::init([](const Vec3<S>& n, S offset) {
             return HalfSpace<S>{n, offset};
           }),
           "normal"_a = Vec3<S>(0, 0, 1), "offset"_a = S(0),
           "All p with normal . p <= offset [m].");
}

template <typename S>
void bind_sensors(py::module_& m) {
  py::class_<SensorParameters<S>>(m, "SensorParameters", "Constants of a sensor (docs/sensors.md).")
      .def(py::init([](S normal_stiffness, S normal_damping, S static_friction, S sliding_friction,
                       S breakaway_distance) {
             return SensorParameters<S>{normal_stiffness, normal_damping, static_friction,
                                        sliding_friction, breakaway_distance};
           }),
           "normal_stiffness"_a, "normal_damping"_a = S(0), "static_friction"_a = S(0),
           "sliding_friction"_a = S(0), "breakaway_distance"_a = S(1e-3),
           "K_N [N], K_D [N s], mu_S [1/m], mu_V [N s/m], sigma_a [m].")
      .def_readwrite("normal_stiffness", &SensorParameters<S>::normal_stiffness,
                     "K_N: force [N] at full depth.")
      .def_readwrite("normal_damping", &SensorParameters<S>::normal_damping, "K_D [N s].")
      .def_readwrite("static_friction", &SensorParameters<S>::static_friction,
                     "mu_S [1/m]: shear for each newton of normal force and metre of stretch.")
      .def_readwrite("sliding_friction", &SensorParameters<S>::sliding_friction, "mu_V [N s/m].")
      .def_readwrite("breakaway_distance", &SensorParameters<S>::breakaway_distance,
                     "sigma_a [m]: stretch at which a bristle lets go.");
  py::class_<SensorLayout<S>>(m, "SensorLayout", "Rays in a body's frame.")
      .def(py::init<>(), "No ray.")
      .def(
          "__len__", [](const SensorLayout<S>& layout) { return layout.size(); }, "Number of rays.")
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
  py::class_<Tuning<S>>(m, "Tuning", "Wants that become constants once the sensors are known.")
      .def(
          "parameters",
          [](const Tuning<S>& tuning, const SensorLayout<S>& layout) {
            return tuning.parameters(layout);
          },
          "sensors"_a, "Constants for a layout that carries the load alone.");
  m.def(
      "tuned_for",
      [](S friction, S creep, S load, S mass, S press, S radius, S normal_damping_ratio,
         S bristle_damping_ratio) {
        return tuned_for<S>({.friction = friction,
                             .creep = creep,
                             .load = load,
                             .mass = mass,
                             .press = press,
                             .radius = radius,
                             .normal_damping_ratio = normal_damping_ratio,
                             .bristle_damping_ratio = bristle_damping_ratio});
      },
      py::kw_only(), "friction"_a = S(0.8), "creep"_a = S(1e-3), "load"_a = S(10), "mass"_a = S(0),
      "press"_a = S(0.3), "radius"_a = S(0), "normal_damping_ratio"_a = S(1),
      "bristle_damping_ratio"_a = S(0.7),
      "Constants of sensors that hold `friction` [1] times their `load` [N], `creep` [m] far, at a "
      "depth of `press` [1] under the load. That of a ball has a `radius` [m]; 0 is a surface that "
      "presses all sensors in alike. They are damped by two ratios [1] for a moved `mass` [kg], "
      "where 0 is the heaviest that is held.");
}

}  // namespace bristle_python
