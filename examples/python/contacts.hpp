/// @file
/// Contacts of worlds in Python, and which bodies meet.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "arrays.hpp"

#include <bristle/bristle.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <span>
#include <utility>
#include <vector>

namespace bristle_python {

/// Points at which shapes are within reach of each other, copied.
template <typename S>
struct WorldContacts {
  /// Of handles.
  py::array body_a, body_b;
  Array<S> position, normal, gap, impulse;

  explicit WorldContacts(const bristle::World<S>& world) {
    py::list bodies_a, bodies_b;
    std::vector<S> positions, normals, gaps, impulses;
    const auto append = [](std::vector<S>& row, const Vec3<S>& vector) {
      row.insert(row.end(), vector.data(), vector.data() + 3);
    };
    world.for_each_contact([&](const ContactReading<S>& contact) {
      contact.for_each_point([&](const typename ContactReading<S>::Point& point) {
        bodies_a.append(contact.body_a);
        bodies_b.append(contact.body_b);
        append(positions, point.position);
        append(normals, point.normal);
        gaps.push_back(point.gap);
        append(impulses, point.normal_impulse * point.normal + point.friction_impulse);
      });
    });
    body_a = handles_of(bodies_a);
    body_b = handles_of(bodies_b);
    const auto vectors = [&](const std::vector<S>& row) {
      return Array<S>({gaps.size(), std::size_t(3)}, row.data());
    };
    position = vectors(positions);
    normal = vectors(normals);
    gap = copied(std::span<const S>(gaps));
    impulse = vectors(impulses);
  }
};

inline void bind_filter(py::module_& m) {
  py::class_<CollisionFilter>(m, "CollisionFilter",
                              "Which bodies meet: two of which each one's mask has a bit of the "
                              "other's category, unless they share a negative group.")
      .def(py::init([](std::uint32_t category, std::uint32_t mask, std::int32_t group) {
             return CollisionFilter{category, mask, group};
           }),
           py::kw_only(), "category"_a = CollisionFilter{}.category,
           "mask"_a = CollisionFilter{}.mask, "group"_a = CollisionFilter{}.group,
           "Bits of the categories of a body, bits of those that it meets, and a group.")
      .def_readonly("category", &CollisionFilter::category, "Bits of its categories.")
      .def_readonly("mask", &CollisionFilter::mask, "Bits of the categories that it meets.")
      .def_readonly("group", &CollisionFilter::group,
                    "Bodies of one negative group never meet; others have no effect.");
}

template <typename S>
void bind_contacts(py::module_& m) {
  using Contacts = WorldContacts<S>;
  py::class_<Contacts>(m, "WorldContacts",
                       "Points at which shapes are within reach of each other: copies, an entry a "
                       "point. Those with a gap above 0 and no impulse do not touch.")
      .def_readonly("body_a", &Contacts::body_a,
                    "[point]: BodyId of one. `contacts.body_a == body` is a mask.")
      .def_readonly("body_b", &Contacts::body_b, "[point]: BodyId of the other.")
      .def_readonly("position", &Contacts::position,
                    "[point, 3]: place [m] when the step began, world axes.")
      .def_readonly("normal", &Contacts::normal,
                    "[point, 3]: unit normal from body_a to body_b, world axes.")
      .def_readonly("gap", &Contacts::gap,
                    "[point]: distance [m] of the surfaces when the step began, negative where "
                    "they overlap.")
      .def_readonly("impulse", &Contacts::impulse,
                    "[point, 3]: impulse [N s] of the step on body_b, friction included, world "
                    "axes. Its negative acts on body_a.");
}

/// What touches what without sensors.
template <typename S, typename Class>
void bind_world_contacts(Class& c) {
  using World = bristle::World<S>;
  c.def(
       "contacts", [](const World& world) { return WorldContacts<S>(world); },
       "Points at which shapes were within reach of each other in the last step, copied.")
      .def(
          "contact_impulse",
          [](const World& world, BodyId body, std::optional<BodyId> other) {
            const Wrench<S> sum =
                other ? world.contact_impulse(body, *other) : world.contact_impulse(body);
            return std::pair(Vec3<S>(sum.force), Vec3<S>(sum.torque));
          },
          "body"_a, "other"_a = py::none(),
          "Impulse [N s] of a body's contacts in the last step and its moment [N m s] about the "
          "centre of mass, world axes: of those with one `other`, or of all. Forces of sensors are "
          "not in it.")
      .def("set_filter", &World::set_filter, "body"_a, "filter"_a,
           "Sets which bodies a body meets. Its island wakes.");
}

}  // namespace bristle_python
