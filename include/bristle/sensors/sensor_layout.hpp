/// @file
/// Rays of a patch's sensors on their body.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/error.hpp>
#include <bristle/geometry/rays/ray.hpp>
#include <bristle/math/types.hpp>

#include <cstddef>
#include <string>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// Rays of many sensors in the frame A of the body that carries them. Each starts inside the body
/// and ends outside.
template <Scalar S>
struct SensorLayout {
  /// [m] Starts of the rays, in A.
  detail::Vec3Array<S> start;
  /// [1] Unit directions of the rays, in A, out of the body.
  detail::Vec3Array<S> direction;
  /// [m] Lengths of the rays, > 0.
  detail::LineArray<S> length;

  /// [-] Number of sensors.
  [[nodiscard]] std::size_t size() const { return length.size(); }
  /// All rays, valid until sensors are added.
  [[nodiscard]] RayBatch<S> rays() const {
    return {start.x, start.y, start.z, direction.x, direction.y, direction.z, length};
  }

  /// Appends a sensor by its ray's start [m], unit direction and length [m], in A.
  void add(const Vec3<S>& p_AStart, const Vec3<S>& direction_A, S reach);

  /// Appends a sensor by its ray's start and end [m], in A.
  void add(const Vec3<S>& p_AStart, const Vec3<S>& p_AEnd);

  /// Appends another layout on the same body.
  void add(const SensorLayout& other);

  /// Checks all sensors, from `add` or set by hand.
  ///
  /// @throws InvalidArgument naming the index of the first sensor whose start is not finite, whose
  ///         ray has no length, or whose direction is not a unit vector; or the array that is
  ///         shorter than the others.
  void validate() const;
};

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
void SensorLayout<S>::add(const Vec3<S>& p_AStart, const Vec3<S>& direction_A, S reach) {
  const std::size_t i = size();
  start.resize(i + 1);
  direction.resize(i + 1);
  start.set(i, p_AStart);
  direction.set(i, direction_A);
  length.push_back(reach);
}

template <Scalar S>
void SensorLayout<S>::add(const Vec3<S>& p_AStart, const Vec3<S>& p_AEnd) {
  const Vec3<S> ray = p_AEnd - p_AStart;
  const S reach = ray.stableNorm();
  // A ray without length keeps a zero direction, which `validate` reports.
  add(p_AStart, reach > S(0) ? Vec3<S>(ray / reach) : ray, reach);
}

template <Scalar S>
void SensorLayout<S>::add(const SensorLayout& other) {
  const std::size_t first = size();
  const std::size_t count = other.size();
  start.resize(first + count);
  direction.resize(first + count);
  length.resize(first + count);
  for (std::size_t i = 0; i < count; ++i) {
    start.set(first + i, other.start[i]);
    direction.set(first + i, other.direction[i]);
    length[first + i] = other.length[i];
  }
}

template <Scalar S>
void SensorLayout<S>::validate() const {
  using std::abs;
  for (const detail::Vec3Array<S>* array : {&start, &direction}) {
    for (const detail::LineArray<S>* axis : {&array->x, &array->y, &array->z}) {
      detail::require(axis->size() == size(), "SensorLayout: size of an array", axis->size(),
                      "must be the number of lengths, " + std::to_string(size()));
    }
  }
  for (std::size_t i = 0; i < size(); ++i) {
    std::string number = "[";
    number.append(std::to_string(i)).append("]");
    detail::require_all_finite("SensorLayout::start" + number, start[i]);
    detail::require_positive("SensorLayout::length" + number, length[i]);
    detail::require_all_finite("SensorLayout::direction" + number, direction[i]);
    detail::require(abs(direction[i].squaredNorm() - S(1)) <= detail::Tolerance<S>::equal(),
                    "SensorLayout::direction" + number + ": length", direction[i].norm(),
                    "must be 1");
  }
}

}  // namespace bristle::inline BRISTLE_ABI
