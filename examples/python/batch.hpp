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
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace bristle_python {

/// A batch and the threads that step it.
template <typename S>
struct ThreadedBatch {
  std::unique_ptr<ThreadPool> pool;
  WorldBatch<S> worlds;

  ThreadedBatch(const World<S>& origin, std::size_t count, unsigned threads)
      : pool(std::make_unique<ThreadPool>(threads)), worlds(origin, count, pool->hook()) {}
};

/// What to gather into: the array that was given, or a new one of this shape.
template <typename T>
[[nodiscard]] Array<T> out_or_new(std::optional<Array<T>> out, std::vector<py::ssize_t> shape) {
  if (!out) return Array<T>(std::move(shape));
  if (out->ndim() != py::ssize_t(shape.size()) ||
      !std::equal(shape.begin(), shape.end(), out->shape())) {
    std::string wanted;
    for (const py::ssize_t n : shape) wanted += (wanted.empty() ? "" : ", ") + std::to_string(n);
    throw InvalidArgument("out.shape", py::str(out->attr("shape")), "must be (" + wanted + ")");
  }
  return *std::move(out);
}
template <typename T>
[[nodiscard]] std::span<T> span_of(Array<T>& array) {
  return {array.mutable_data(), static_cast<std::size_t>(array.size())};  // throws if read-only
}
[[nodiscard]] inline WorldBatch<double>::Mask mask_of(const std::optional<ArrayLike<bool>>& mask) {
  if (!mask) return {};
  if (mask->size() == 0) throw InvalidArgument("mask.size", "0", "must be the number of worlds");
  return {reinterpret_cast<const std::uint8_t*>(mask->data()),
          static_cast<std::size_t>(mask->size())};
}

template <typename S>
void bind_batch(py::module_& m) {
  using Batch = ThreadedBatch<S>;
  using Out = std::optional<Array<S>>;
  const auto length = [](const auto& items) { return static_cast<py::ssize_t>(items.size()); };
  py::class_<Batch>(m, "WorldBatch", "Copies of one world that step together (docs/batches.md).")
      .def(py::init<const World<S>&, std::size_t, unsigned>(), "origin"_a, "count"_a,
           "threads"_a = 1u)
      .def("__len__", [](const Batch& batch) { return batch.worlds.size(); })
      .def(
          "__getitem__",
          [](Batch& batch, std::size_t number) -> World<S>& {
            if (number >= batch.worlds.size()) throw py::index_error("no world of this number");
            return batch.worlds.world(number);
          },
          py::return_value_policy::reference_internal)
      .def(
          "step", [](Batch& batch, std::size_t steps) { batch.worlds.step(steps); }, "steps"_a = 1,
          py::call_guard<py::gil_scoped_release>())
      .def(
          "reset",
          [](Batch& batch, const std::optional<ArrayLike<bool>>& mask) {
            batch.worlds.reset(mask_of(mask));
          },
          "mask"_a = py::none(), "Puts the worlds of a mask, or all, back to their start.")
      .def_property_readonly(
          "failed",
          [length](const Batch& batch) {
            Array<bool> result(length(batch.worlds.failed()));
            std::copy(batch.worlds.failed().begin(), batch.worlds.failed().end(),
                      result.mutable_data());
            return result;
          },
          "Which worlds have had a step that could not be computed, since their last reset.")
      .def(
          "set_mass",
          [](Batch& batch, BodyId body, const ArrayLike<S>& masses) {
            if (masses.size() != py::ssize_t(batch.worlds.size())) {
              throw InvalidArgument("masses.size", std::to_string(masses.size()),
                                    "must be the number of worlds");
            }
            const S* mass = masses.data();
            batch.worlds.for_each(
                [&](std::size_t i, World<S>& world) { world.set_mass(body, mass[i]); });
          },
          "body"_a, "masses"_a, "[kg] A mass for each world.")
      .def(
          "bodies",
          [length](const Batch& batch, const std::vector<BodyId>& ids, Out out) {
            auto to = out_or_new<S>(std::move(out), {length(batch.worlds), length(ids), 13});
            batch.worlds.gather_bodies(ids, span_of(to));
            return to;
          },
          "bodies"_a, py::arg("out").noconvert() = py::none(),
          "[world, body, 13]: position, quaternion x y z w, velocity, angular velocity.")
      .def(
          "joints",
          [length](const Batch& batch, const std::vector<JointId>& ids, Out out) {
            auto to = out_or_new<S>(std::move(out), {length(batch.worlds), length(ids), 2});
            batch.worlds.gather_joints(ids, span_of(to));
            return to;
          },
          "joints"_a, py::arg("out").noconvert() = py::none(), "[world, joint, 2].")
      .def(
          "taxels",
          [length](const Batch& batch, const std::vector<PatchId>& ids, Out out) {
            const World<S>& first = batch.worlds.world(0);
            const std::size_t sensors = ids.empty() ? 0 : first.patch(ids.front()).size();
            auto to = out_or_new<S>(std::move(out), {length(batch.worlds), length(ids), 4,
                                                     static_cast<py::ssize_t>(sensors)});
            batch.worlds.gather_taxels(ids, span_of(to));
            return to;
          },
          "patches"_a, py::arg("out").noconvert() = py::none(),
          "[world, patch, channel, sensor]: depth [1], normal force, shear 1 and 2 [N].");
}

}  // namespace bristle_python
