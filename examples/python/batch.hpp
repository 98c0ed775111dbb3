/// @file
/// Batches of worlds in Python.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "arrays.hpp"

#include <bristle/bristle.hpp>
#include <bristle/core/thread_pool.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace bristle_python {

/// Worlds of a batch that are meant: an array of bool, or none for all.
class WorldMask {
 public:
  /// @throws TypeError when it is no bool, InvalidArgument when it is of another size: numbers of
  ///         worlds would otherwise pass for a mask.
  WorldMask(const py::object& mask, std::size_t worlds) {
    if (mask.is_none()) return;
    const py::array array = array_of("mask", mask);
    const std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(worlds)};
    if (!has_shape(array, shape)) {
      throw InvalidArgument("mask.shape", py::str(array.attr("shape")),
                            "must be " + shape_text(shape) + ", a bool for each world");
    }
    if (array.dtype().kind() != 'b') {
      throw py::type_error("mask: dtype " + std::string(py::str(array.dtype())) + ": must be bool");
    }
    bytes_ = Array<bool>(array);
  }
  [[nodiscard]] std::span<const std::uint8_t> get() const {
    return {reinterpret_cast<const std::uint8_t*>(bytes_.data()),
            static_cast<std::size_t>(bytes_.size())};
  }

 private:
  Array<bool> bytes_;
};

/// A batch and the threads that step it.
template <typename S>
struct ThreadedBatch {
  std::unique_ptr<ThreadPool> pool;
  World<S> origin;
  WorldBatch<S> worlds;

  ThreadedBatch(const World<S>& start, std::size_t count, unsigned threads)
      : pool(std::make_unique<ThreadPool>(threads)),
        origin(start),
        worlds(start, count, pool->hook()) {}

  /// Does the same to all worlds of a mask, or raises and does nothing: what a world refuses, a
  /// copy of the original refuses first, its body in the state of the one in that world.
  template <typename Id, typename Change>
  void change(Id id, const py::object& worlds_meant, const Change& change) {
    const WorldMask mask(worlds_meant, worlds.size());
    World<S> probe = origin;
    for (std::size_t i = 0; i < worlds.size(); ++i) {
      if (!mask.get().empty() && mask.get()[i] == 0) continue;
      if (!std::as_const(worlds).world(i).contains(id)) {
        throw InvalidArgument("handle", to_text(id), "must name what all worlds have");
      }
      if constexpr (std::is_same_v<Id, BodyId>) put_in_state_of(worlds.world(i), id, probe);
      change(i, probe);
    }
    worlds.for_each(change, mask.get());
  }

 private:
  /// Lets a body of a copy stand, move, weigh and be pushed as that of a world, to rounding:
  /// whether a force, an impulse or a way is too large depends on these.
  static void put_in_state_of(const World<S>& world, BodyId id, World<S>& copy) {
    const Body<S>& body = world.body(id);
    copy.set_pose(id, body.pose());
    copy.apply_wrench(id, -copy.body(id).applied);
    copy.apply_wrench(id, body.applied);
    if (body.motion != Motion::fixed) copy.set_velocity(id, body.twist);
    if (body.is_dynamic()) copy.set_mass(id, body.mass);
  }
};

template <typename S>
[[nodiscard]] Transform<S> pose_of(const S* position, const S* xyzw) {
  return {Quat<S>(xyzw[3], xyzw[0], xyzw[1], xyzw[2]), vec3_at(position)};
}

/// A change of a body by two rows of numbers for each world.
/// @param names   Names of the rows, and the lengths of each.
/// @param change  Callable: change(world, body, first number of a row, and of the other).
template <typename S, typename Change>
[[nodiscard]] auto by_two_rows(std::pair<const char*, py::ssize_t> first,
                               std::pair<const char*, py::ssize_t> second, Change change) {
  return [=](ThreadedBatch<S>& batch, BodyId body, const py::object& a, const py::object& b,
             const py::object& mask) {
    const Rows<S> x(first.first, a, batch.worlds.size(), first.second);
    const Rows<S> y(second.first, b, batch.worlds.size(), second.second);
    batch.change(body, mask,
                 [&](std::size_t i, World<S>& world) { change(world, body, x[i], y[i]); });
  };
}

/// What is read of things of all worlds into one array.
/// @param gather    Function of `WorldBatch` that fills it.
/// @param shape_of  Callable: shape_of(batch, ids), the shape of what one thing gives.
template <typename S, typename Id, typename T, typename ShapeOf>
[[nodiscard]] auto gathered(void (WorldBatch<S>::*gather)(std::span<const Id>, std::span<T>) const,
                            ShapeOf shape_of) {
  return [=](const ThreadedBatch<S>& batch, const std::vector<Id>& ids, const py::object& out) {
    std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(batch.worlds.size()),
                                   static_cast<py::ssize_t>(ids.size())};
    for (const py::ssize_t n : shape_of(batch, ids)) shape.push_back(n);
    auto to = out_or_new<T>(out, std::move(shape));
    (batch.worlds.*gather)(ids, span_of(to));
    return to;
  };
}

/// What differs from world to world, before or between steps.
template <typename S, typename Class>
void bind_batch_changes(Class& c) {
  using Batch = ThreadedBatch<S>;
  const py::tuple upright = py::make_tuple(0, 0, 0, 1);
  c.def(
       "set_mass",
       [](Batch& batch, BodyId body, const py::object& masses, const py::object& mask) {
         const Rows<S> mass("masses", masses, batch.worlds.size());
         batch.change(body, mask, [&](std::size_t i, World<S>& w) { w.set_mass(body, *mass[i]); });
       },
       "body"_a, "masses"_a, "mask"_a = py::none(),
       "Gives a body a mass [kg] for each world; its inertia follows in proportion.")
      .def(
          "set_material",
          [](Batch& batch, BodyId body, const py::object& friction, const py::object& restitution,
             const py::object& mask, const py::object& rolling_friction,
             const py::object& surface_velocity) {
            const Rows<S> mu("friction", friction, batch.worlds.size());
            const Rows<S> e("restitution", restitution, batch.worlds.size());
            const Rows<S> lever("rolling_friction", rolling_friction, batch.worlds.size());
            const Rows<S> v("surface_velocity", surface_velocity, batch.worlds.size(), 3);
            batch.change(body, mask, [&](std::size_t i, World<S>& w) {
              w.set_material(body, {.friction = *mu[i],
                                    .restitution = *e[i],
                                    .surface_velocity = vec3_at(v[i]),
                                    .rolling_friction = *lever[i]});
            });
          },
          "body"_a, "friction"_a, "restitution"_a = 0, "mask"_a = py::none(),
          "rolling_friction"_a = 0, "surface_velocity"_a = py::make_tuple(0, 0, 0),
          "Gives all shapes of a body a friction [1], a restitution [1], a lever of rolling "
          "friction [m] and a velocity of the surface [m/s], [world, 3], for each world.")
      .def("set_damping",
           by_two_rows<S>({"linear", 0}, {"angular", 0},
                          [](World<S>& world, BodyId body, const S* v, const S* w) {
                            world.set_damping(body, *v, *w);
                          }),
           "body"_a, "linear"_a, "angular"_a = 0, "mask"_a = py::none(),
           "Rates [1/s] at which velocity and angular momentum of a dynamic body decay, for each "
           "world.")
      .def(
          "set_gravity_scale",
          [](Batch& batch, BodyId body, const py::object& scales, const py::object& mask) {
            const Rows<S> scale("scales", scales, batch.worlds.size());
            batch.change(body, mask,
                         [&](std::size_t i, World<S>& w) { w.set_gravity_scale(body, *scale[i]); });
          },
          "body"_a, "scales"_a, "mask"_a = py::none(),
          "Factor [1] of a dynamic body on gravity, for each world.")
      .def(
          "set_parameters",
          [](Batch& batch, PatchId patch,
             const std::variant<SensorParameters<S>, std::vector<SensorParameters<S>>>& parameters,
             const py::object& mask) {
            const auto* each = std::get_if<std::vector<SensorParameters<S>>>(&parameters);
            if (each != nullptr && each->size() != batch.worlds.size()) {
              throw InvalidArgument("len(parameters)", std::to_string(each->size()),
                                    "must be " + std::to_string(batch.worlds.size()));
            }
            batch.change(patch, mask, [&](std::size_t i, World<S>& w) {
              w.set_parameters(patch, each ? (*each)[i] : std::get<0>(parameters));
            });
          },
          "patch"_a, "parameters"_a, "mask"_a = py::none(),
          "Gives the sensors of a patch constants: the same in all worlds, or a list, one a world.")
      .def(
          "set_motor",
          [](Batch& batch, JointId joint, MotorMode mode, const py::object& target,
             const py::object& max_force, const py::object& max_speed, const py::object& stiffness,
             const py::object& damping, const py::object& mask) {
            const std::size_t n = batch.worlds.size();
            const Rows<S> q("target", target, n), f("max_force", max_force, n);
            const Rows<S> v("max_speed", max_speed, n), k("stiffness", stiffness, n);
            const Rows<S> d("damping", damping, n);
            batch.change(joint, mask, [&](std::size_t i, World<S>& w) {
              w.set_motor(joint, {mode, *q[i], *f[i], *v[i], *k[i], *d[i]});
            });
          },
          "joint"_a, py::kw_only(), "mode"_a, "target"_a = 0, "max_force"_a = 0,
          "max_speed"_a = py::float_(infinity<double>), "stiffness"_a = 0, "damping"_a = 0,
          "mask"_a = py::none(),
          "Drives a joint: numbers [m or m/s, N, m/s, N/m, N s/m; of angles rad and N m] for each "
          "world or for all.")
      .def("set_pose",
           by_two_rows<S>({"positions", 3}, {"orientations", 4},
                          [](World<S>& world, BodyId body, const S* p, const S* q) {
                            world.set_pose(body, pose_of(p, q));
                          }),
           "body"_a, "positions"_a, "orientations"_a = upright, "mask"_a = py::none(),
           "Puts a body somewhere else at once: [world, 3] in m, [world, 4] as x, y, z, w.")
      .def("move_to",
           by_two_rows<S>({"positions", 3}, {"orientations", 4},
                          [](World<S>& world, BodyId body, const S* p, const S* q) {
                            world.move_to(body, pose_of(p, q));
                          }),
           "body"_a, "positions"_a, "orientations"_a = upright, "mask"_a = py::none(),
           "Where a kinematic body is to be after the next step: [world, 3] in m, [world, 4]. It "
           "keeps that velocity in the steps after it.")
      .def("set_velocity",
           by_two_rows<S>({"linear", 3}, {"angular", 3},
                          [](World<S>& world, BodyId body, const S* v, const S* w) {
                            world.set_velocity(body, {vec3_at(v), vec3_at(w)});
                          }),
           "body"_a, "linear"_a, "angular"_a = py::make_tuple(0, 0, 0), "mask"_a = py::none(),
           "Velocity of the centre of mass [m/s] and angular velocity [rad/s]: [world, 3] each.")
      .def("apply_force",
           by_two_rows<S>({"forces", 3}, {"points", 3},
                          [](World<S>& world, BodyId body, const S* f, const S* p) {
                            world.apply_force(body, vec3_at(f), vec3_at(p));
                          }),
           "body"_a, "forces"_a, "points"_a, "mask"_a = py::none(),
           "Adds a force [N] at a point [m] of each world, [world, 3] each, that acts during its "
           "next step.")
      .def("apply_impulse",
           by_two_rows<S>({"impulses", 3}, {"points", 3},
                          [](World<S>& world, BodyId body, const S* j, const S* p) {
                            world.apply_impulse(body, vec3_at(j), vec3_at(p));
                          }),
           "body"_a, "impulses"_a, "points"_a, "mask"_a = py::none(),
           "Changes the velocity of a dynamic body at once by an impulse [N s] at a point [m] of "
           "each world, [world, 3] each.");
}

/// What is read of all worlds into one array.
template <typename S, typename Class>
void bind_batch_gathers(Class& c) {
  using Batch = ThreadedBatch<S>;
  using Worlds = WorldBatch<S>;
  using Shape = std::vector<py::ssize_t>;
  const auto out = py::arg("out") = py::none();
  const auto each = [](Shape shape) {
    return [shape](const Batch&, const auto&) { return shape; };
  };
  // All patches have as many, or the gather refuses them.
  const auto sensors_in = [](const Batch& batch, const std::vector<PatchId>& ids) {
    const World<S>& first = batch.worlds.world(0);
    return static_cast<py::ssize_t>(ids.empty() ? 0 : first.patch(ids.front()).size());
  };
  c.def("bodies", gathered(&Worlds::gather_bodies, each({13})), "bodies"_a, out,
        "[world, body, 13]: position [m], quaternion x y z w, velocity of the centre of mass "
        "[m/s], angular velocity [rad/s]; world axes.")
      .def("joints", gathered(&Worlds::gather_joints, each({2})), "joints"_a, out,
           "[world, joint, 2]: position [m or rad] and velocity [m/s or rad/s].")
      .def("taxels",
           gathered(&Worlds::gather_taxels,
                    [sensors_in](const Batch& batch, const std::vector<PatchId>& ids) {
                      return Shape{4, sensors_in(batch, ids)};
                    }),
           "patches"_a, out,
           "[world, patch, channel, sensor]: depth [1], normal force, shear along t1 and t2 [N].")
      .def("points",
           gathered(&Worlds::gather_points,
                    [sensors_in](const Batch& batch, const std::vector<PatchId>& ids) {
                      return Shape{sensors_in(batch, ids), 6};
                    }),
           "patches"_a, out,
           "[world, patch, sensor, 6]: how far the skin is displaced at a sensor, dx, dy, dz [m], "
           "and the force on it, Fx, Fy, Fz [N], in the axes of the patch's body.")
      .def("touching", gathered(&Worlds::gather_touching, each({})), "patches"_a, out,
           "[world, patch]: number of sensors that touch something.");
}

template <typename S>
void bind_batch(py::module_& m) {
  using Batch = ThreadedBatch<S>;
  py::class_<Batch> c(m, "WorldBatch",
                      "Copies of one world that step together, on threads of their own. What "
                      "changes worlds changes all of a mask of bool, or raises and changes none.");
  c.def(py::init<const World<S>&, std::size_t, unsigned>(), "origin"_a, "count"_a, "threads"_a = 1u,
        "Copies `origin`: what all worlds start as and are reset to.")
      .def(
          "__len__", [](const Batch& batch) { return batch.worlds.size(); }, "Number of worlds.")
      .def(
          "__getitem__",
          [](Batch& batch, py::ssize_t number) -> World<S>& {
            const auto count = static_cast<py::ssize_t>(batch.worlds.size());
            if (number < 0 || number >= count) {
              throw py::index_error("no world " + std::to_string(number) + ": must be from 0 to " +
                                    std::to_string(count - 1));
            }
            return batch.worlds.world(static_cast<std::size_t>(number));
          },
          "number"_a, py::return_value_policy::reference_internal,
          "The world of a number, itself and no copy.")
      .def(
          "step", [](Batch& batch, std::size_t steps) { batch.worlds.step(steps); }, "steps"_a = 1,
          py::call_guard<py::gil_scoped_release>(),
          "Advances all worlds by some steps each. Other Python threads run meanwhile.")
      .def(
          "reset",
          [](Batch& batch, const py::object& mask, const World<S>* start) {
            batch.worlds.reset_to(start != nullptr ? *start : batch.origin,
                                  WorldMask(mask, batch.worlds.size()).get());
          },
          "mask"_a = py::none(), "start"_a = py::none(),
          "Puts the worlds of a mask, or all, back to their start, masses and surfaces included; "
          "or "
          "to the state of the world `start`.")
      .def_property_readonly(
          "failed",
          [](const Batch& batch) {
            Array<bool> result(static_cast<py::ssize_t>(batch.worlds.size()));
            std::copy(batch.worlds.failed().begin(), batch.worlds.failed().end(),
                      result.mutable_data());
            return result;
          },
          "[world]: which worlds have had a step that could not be computed, since their reset.");
  bind_batch_changes<S>(c);
  bind_batch_gathers<S>(c);
}

}  // namespace bristle_python
