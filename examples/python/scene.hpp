/// @file
/// Scene files in Python, where the library was built with yaml-cpp.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "arrays.hpp"

#include <bristle/bristle.hpp>
#if defined(BRISTLE_PYTHON_WITH_ADF)
#include <bristle/io/adf.hpp>
#endif

#include <pybind11/pybind11.h>
#include <string>

namespace bristle_python {

/// What a file added to a world, by name.
struct Scene {
  py::dict bodies, joints, patches;
  std::string report;
};

inline void bind_scene_type(py::module_& m) {
  py::class_<Scene>(m, "Scene", "What a scene file added to a world.")
      .def_readonly("bodies", &Scene::bodies,
                    "BodyId by name; a name that several have is its qualified one.")
      .def_readonly("joints", &Scene::joints, "JointId by name.")
      .def_readonly("patches", &Scene::patches, "PatchId by name.")
      .def_readonly("report", &Scene::report, "A line for each thing not taken as it stands.");
}

#if defined(BRISTLE_PYTHON_WITH_ADF)
/// @param names  One of the lists of names of an AdfScene.
template <typename Names>
[[nodiscard]] py::dict by_name(const Names& names) {
  py::dict result;
  for (const auto& entry : names) {
    const bool is_only = names.find(entry.name) == &entry.value;
    result[py::str(is_only ? entry.name : entry.qualified)] = entry.value;
  }
  return result;
}
#endif

/// @param path  Name of the file.
template <typename S>
[[nodiscard]] Scene add_scene([[maybe_unused]] World<S>& world,
                              [[maybe_unused]] const std::string& path,
                              [[maybe_unused]] bool hold_joints) {
#if defined(BRISTLE_PYTHON_WITH_ADF)
  const AdfScene<S> scene = add_adf(world, path, AdfBuildDef<S>{.hold_joints = hold_joints});
  return {by_name(scene.bodies), by_name(scene.joints), by_name(scene.patches),
          scene.report.text()};
#else
  PyErr_SetString(PyExc_NotImplementedError,
                  "add_scene: this module was built without yaml-cpp, which reads scene files");
  throw py::error_already_set();
#endif
}

template <typename S>
void bind_scene(py::module_& m) {
  m.def("add_scene", &add_scene<S>, "world"_a, "path"_a, "hold_joints"_a = false,
        "Adds the bodies, joints and patches of a file in AMBF's description format to a world "
        "(docs/adf.md). With `hold_joints` those with a controller are held where they stand. "
        "IoError names line, key and rule of what is wrong, and the world is unchanged then; "
        "NotImplementedError where the module was built without yaml-cpp.");
}

}  // namespace bristle_python
