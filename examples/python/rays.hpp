/// @file
/// Rays through worlds in Python.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "arrays.hpp"

#include <bristle/bristle.hpp>

#include <cstddef>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <span>
#include <vector>

namespace bristle_python {

/// What rays hit, copied.
template <typename S>
struct WorldHits {
  Array<S> distance, point, normal;
  Array<bool> is_hit;
  /// Of handles, and None where nothing was hit.
  py::array body;

  explicit WorldHits(std::span<const WorldHit<S>> hits)
      : distance(static_cast<py::ssize_t>(hits.size())),
        point({hits.size(), std::size_t(3)}),
        normal({hits.size(), std::size_t(3)}),
        is_hit(static_cast<py::ssize_t>(hits.size())) {
    py::list bodies;
    for (std::size_t i = 0; i < hits.size(); ++i) {
      const auto k = static_cast<py::ssize_t>(i);
      distance.mutable_at(k) = hits[i].distance;
      for (py::ssize_t axis = 0; axis < 3; ++axis) {
        point.mutable_at(k, axis) = hits[i].point[axis];
        normal.mutable_at(k, axis) = hits[i].normal[axis];
      }
      is_hit.mutable_at(k) = hits[i].is_hit();
      bodies.append(hits[i].is_hit() ? py::cast(hits[i].body) : py::none());
    }
    body = handles_of(bodies);
  }
};

/// Rays of rows: [ray, 3] in m, [ray, 3] and [ray] in m, each of which may be one for all.
/// @throws as `Rows`.
template <typename S>
[[nodiscard]] std::vector<Ray<S>> rays_of(const py::object& origins, const py::object& directions,
                                          const py::object& max_distance) {
  const py::array starts = array_of("origins", origins);
  const py::array ways = array_of("directions", directions);
  const py::array& counted = ways.ndim() == 2 ? ways : starts;
  const std::size_t count =
      counted.ndim() == 2 ? static_cast<std::size_t>(counted.shape(0)) : std::size_t(1);
  const Rows<S> start("origins", starts, count, 3, "ray");
  const Rows<S> way("directions", ways, count, 3, "ray");
  const Rows<S> length("max_distance", max_distance, count, 0, "ray");
  std::vector<Ray<S>> rays;
  for (std::size_t i = 0; i < count; ++i) {
    rays.push_back({vec3_at(start[i]), vec3_at(way[i]), *length[i]});
  }
  return rays;
}

template <typename S>
void bind_hits(py::module_& m) {
  py::class_<WorldHits<S>>(m, "WorldHits", "What rays hit: copies, an entry a ray.")
      .def_readonly("is_hit", &WorldHits<S>::is_hit, "[ray]: which hit something.")
      .def_readonly("distance", &WorldHits<S>::distance,
                    "[ray]: way [m] to the hit; infinite without one, 0 where a ray starts inside.")
      .def_readonly("point", &WorldHits<S>::point,
                    "[ray, 3]: point of the hit [m], world axes; valid where `is_hit`.")
      .def_readonly("normal", &WorldHits<S>::normal,
                    "[ray, 3]: outward unit normal there, world axes; valid where `is_hit`. "
                    "Against the ray where it starts inside.")
      .def_readonly("body", &WorldHits<S>::body,
                    "[ray]: BodyId that was hit, or None. `hits.body == body` is a mask.");
}

/// Questions to a world.
template <typename S, typename Class>
void bind_world_queries(Class& c) {
  using World = bristle::World<S>;
  c.def(
      "cast_rays",
      [](const World& world, const py::object& origins, const py::object& directions,
         const py::object& max_distance, const std::vector<BodyId>& excluded, bool meets_triggers) {
        const std::vector<Ray<S>> rays = rays_of<S>(origins, directions, max_distance);
        std::vector<WorldHit<S>> hits(rays.size());
        world.cast_rays(rays, {.excluded = excluded, .meets_triggers = meets_triggers}, hits);
        return WorldHits<S>(hits);
      },
      "origins"_a, "directions"_a, "max_distance"_a = py::float_(infinity<double>), py::kw_only(),
      "excluded"_a = std::vector<BodyId>{}, "meets_triggers"_a = false,
      "Nearest hits of rays: [ray, 3] from where [m], [ray, 3] unit directions, [ray] how far [m]; "
      "each may be one for all rays. Bodies that are `excluded` are not met, nor are triggers.");
}

}  // namespace bristle_python
