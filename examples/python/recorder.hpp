/// @file
/// Recorders of worlds in Python.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "arrays.hpp"

#include <bristle/bristle.hpp>
#include <bristle/io/glb.hpp>
#include <bristle/io/recorder.hpp>

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <string>
#include <utility>

namespace bristle_python {

template <typename S>
void bind_recorder(py::module_& m) {
  using Recorder = bristle::Recorder<S>;
  py::class_<Recorder>(m, "Recorder",
                       "Keeps how chosen bodies of a world moved and what chosen patches felt, for "
                       "a replay (docs/replay.md).")
      .def(py::init<double>(), "rate"_a = 60.0,
           "Takes `rate` frames a second [1/s], or one a step where steps are longer.")
      .def(
          "add_body",
          [](Recorder& recorder, const World<S>& world, BodyId body, const Shape<S>& shape,
             std::string name, S plane_size) {
            BodyDef<S> def;
            def.motion = world.body(body).motion;
            def.shape = shape;
            recorder.add_body(body, def, std::move(name), plane_size);
          },
          "world"_a, "body"_a, "shape"_a, "name"_a, "plane_size"_a = S(2),
          "Records a body, which looks like `shape`, from the next frame on. A half-space is drawn "
          "as a square of side `plane_size` [m].")
      .def(
          "add_patch",
          [](Recorder& recorder, const World<S>& world, PatchId patch, std::string name) {
            recorder.add_patch(world, patch, std::move(name));
          },
          "world"_a, "patch"_a, "name"_a,
          "Records the forces [N] of a patch on a body that is recorded.")
      .def(
          "observe", [](Recorder& recorder, const World<S>& world) { recorder.observe(world); },
          "world"_a,
          "To be called after each step: takes a frame when it is time for one. Raises "
          "InvalidArgument for another world than before, a copy too; see `follow`.")
      .def(
          "follow", [](Recorder& recorder, const World<S>& world) { recorder.follow(world); },
          "world"_a, "Goes on with a copy of the world. A batch gives a copy of a world each time.")
      .def_property_readonly(
          "times",
          [](const Recorder& recorder) {
            return copied(std::span<const double>(recorder.recording().times));
          },
          "[frame]: instants [s] since the first step that was observed.")
      .def(
          "write_glb",
          [](const Recorder& recorder, const std::string& path, double longest_arrow) {
            write_glb(path, recorder.recording(), {.longest_arrow = longest_arrow});
          },
          "path"_a, "longest_arrow"_a = GlbDef{}.longest_arrow,
          "Writes the recording as binary glTF. The arrow of the largest force of a sensor is "
          "`longest_arrow` [m] long.");
}

}  // namespace bristle_python
