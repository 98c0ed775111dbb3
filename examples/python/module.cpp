// The compiled part of the Python package `bristle`: worlds, sensors and batches in double, and in
// float as `bristle.float32` (docs/python.md).
// SPDX-License-Identifier: BSD-3-Clause
#include "batch.hpp"
#include "events.hpp"
#include "meshes.hpp"
#include "plot.hpp"
#include "rays.hpp"
#include "recorder.hpp"
#include "scene.hpp"
#include "sensors.hpp"
#include "world.hpp"

#include <bristle/bristle.hpp>

#include <functional>
#include <pybind11/operators.h>
#include <pybind11/pybind11.h>
#include <string>

namespace bristle_python {
namespace {

template <typename T>
void bind_handle(py::module_& m, const char* name) {
  py::class_<T>(m, name, "Names a thing of a world, and the same one in its copies.")
      .def(py::self == py::self)
      .def("__hash__", [](const T& id) { return std::hash<T>()(id); })
      .def("__repr__", [name = std::string(name)](const T& id) { return name + to_text(id); });
}

/// What does not depend on the scalar.
void bind_common(py::module_& m) {
  py::enum_<Motion>(m, "Motion", "What makes a body move.")
      .value("fixed", Motion::fixed)
      .value("kinematic", Motion::kinematic)
      .value("dynamic", Motion::dynamic);
  py::enum_<Integration>(m, "Integration", "How the forces of a patch enter the step.")
      .value("explicit", Integration::explicit_)
      .value("implicit", Integration::implicit)
      .value("automatic", Integration::automatic);
  py::enum_<SlipReset>(m, "SlipReset", "What becomes of an overstretched bristle.")
      .value("release", SlipReset::release)
      .value("drag", SlipReset::drag);
  py::enum_<NormalDirection>(m, "NormalDirection", "Along what the normal force points.")
      .value("ray", NormalDirection::ray)
      .value("gradient", NormalDirection::gradient);
  py::enum_<JointKind>(m, "JointKind", "What a joint leaves free.")
      .value("fixed", JointKind::fixed)
      .value("revolute", JointKind::revolute)
      .value("prismatic", JointKind::prismatic)
      .value("ball", JointKind::ball)
      .value("cone_twist", JointKind::cone_twist)
      .value("six_dof", JointKind::six_dof);
  py::enum_<MotorMode>(m, "MotorMode", "What drives the free axis of a joint.")
      .value("none", MotorMode::none)
      .value("velocity", MotorMode::velocity)
      .value("position", MotorMode::position)
      .value("spring", MotorMode::spring);
  bind_handle<BodyId>(m, "BodyId");
  bind_handle<JointId>(m, "JointId");
  bind_handle<PatchId>(m, "PatchId");
  bind_handle<ShapeId>(m, "ShapeId");

  bind_filter(m);
  bind_event_types(m);
  bind_scene_type(m);
  bind_plot(m);

  py::register_exception<InvalidArgument>(m, "InvalidArgument", PyExc_ValueError);
  py::register_exception<IoError>(m, "IoError", PyExc_OSError);
}

template <typename S>
void bind_scalar(py::module_& m) {
  bind_shapes<S>(m);
  bind_meshes<S>(m);
  bind_sensors<S>(m);
  bind_hits<S>(m);
  bind_contacts<S>(m);
  bind_reading<S>(m);
  bind_world<S>(m);
  bind_batch<S>(m);
  bind_recorder<S>(m);
  bind_scene<S>(m);
}

}  // namespace
}  // namespace bristle_python

PYBIND11_MODULE(_core, m) {
  m.doc() =
      "The compiled part of bristle: worlds, sensors and batches in double; "
      "_float32 has the same in float.";
  m.attr("__version__") = BRISTLE_VERSION_STRING;
  bristle_python::bind_common(m);
  bristle_python::bind_scalar<double>(m);
  pybind11::module_ single = m.def_submodule("_float32", "Worlds in float.");
  bristle_python::bind_scalar<float>(single);
}
