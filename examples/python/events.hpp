/// @file
/// Events of worlds in Python: who began and ceased to touch whom.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "arrays.hpp"

#include <bristle/bristle.hpp>

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <string>
#include <vector>

namespace bristle_python {

/// True for what began to touch, false for what ceased to.
[[nodiscard]] inline bool begins(const ContactEvent& event) {
  return event.phase == ContactEvent::Phase::begin;
}

inline void bind_event_types(py::module_& m) {
  const auto text_of = [](const py::object& event, const std::vector<const char*>& fields) {
    std::string text;
    for (const char* field : fields) {
      text += (text.empty() ? "" : ", ") + std::string(field) + "=" +
              std::string(py::repr(event.attr(field)));
    }
    return std::string(py::str(py::type::of(event).attr("__name__"))) + "(" + text + ")";
  };
  py::class_<TouchEvent>(m, "TouchEvent",
                         "A patch and a body that began to touch, or no longer do.")
      .def_readonly("patch", &TouchEvent::patch, "The patch. After an end it may be removed.")
      .def_readonly("body", &TouchEvent::body,
                    "The body that its sensors touch. After an end it may be removed.")
      .def_readonly("begins", &TouchEvent::begins, "True for a begin, False for an end.")
      .def("__repr__", [text_of](const py::object& event) {
        return text_of(event, {"patch", "body", "begins"});
      });
  py::class_<ContactEvent>(m, "ContactEvent",
                           "Two shapes of two bodies that began to touch, or no longer do.")
      .def_readonly("body_a", &ContactEvent::body_a,
                    "The body of `shape_a`. After an end it may be removed.")
      .def_readonly("body_b", &ContactEvent::body_b,
                    "The body of `shape_b`. After an end it may be removed.")
      .def_readonly("shape_a", &ContactEvent::shape_a,
                    "The shape with the smaller number; tells the shapes of a body apart.")
      .def_readonly("shape_b", &ContactEvent::shape_b, "The shape with the larger number.")
      .def_property_readonly("begins", &begins, "True for a begin, False for an end.")
      .def("__repr__", [text_of](const py::object& event) {
        return text_of(event, {"body_a", "body_b", "shape_a", "shape_b", "begins"});
      });
}

/// Events that a world keeps.
template <typename S, typename Class>
void bind_world_events(Class& c) {
  using World = bristle::World<S>;
  const auto listed = [](const auto& events) { return std::vector(events.begin(), events.end()); };
  c.def("keep_touch_events", &World::keep_touch_events, "on"_a = true,
        "Starts or ends to keep events of touches. After a start the next step reports all bodies "
        "that patches touch then. Both forget what was kept.")
      .def(
          "touch_events", [listed](const World& world) { return listed(world.touch_events()); },
          "Which patch began and ceased to touch which body since the last `clear_touch_events`, "
          "in the order of steps, as copies. Empty unless `keep_touch_events`.")
      .def("clear_touch_events", &World::clear_touch_events,
           "Forgets all events of touches kept so far.")
      .def(
          "contact_events", [listed](const World& world) { return listed(world.contact_events()); },
          "Which shapes began and ceased to touch since the last `clear_contact_events`, in the "
          "order of steps, as copies. What is in a trigger touches it. Empty unless the world was "
          "made with `keeps_contact_events`, and after `restore`.")
      .def("clear_contact_events", &World::clear_contact_events,
           "Forgets all events of contacts kept so far.");
}

}  // namespace bristle_python
