/// @file
/// Arrays of numpy, quaternions in their order, and the names that all of the binding uses.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/math/types.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace bristle_python {

namespace py = pybind11;
using namespace py::literals;
using namespace bristle;

/// An array in C order of exactly this type: what is given out, and what is written into.
template <typename T>
using Array = py::array_t<T, py::array::c_style>;

template <typename T>
[[nodiscard]] Array<T> copied(std::span<const T> values) {
  return Array<T>(static_cast<py::ssize_t>(values.size()), values.data());
}

/// Handles, or None, as an array whose comparison with a handle is a mask.
[[nodiscard]] inline py::array handles_of(const py::list& handles) {
  return py::module_::import("numpy").attr("array")(handles, "dtype"_a = "object");
}

/// Quaternions are x, y, z, w in Python.
template <typename S>
[[nodiscard]] Quat<S> rotation_of(const Eigen::Matrix<S, 4, 1>& xyzw) {
  return Quat<S>(xyzw[3], xyzw[0], xyzw[1], xyzw[2]);
}

/// The vector that starts at a number of an array.
template <typename S>
[[nodiscard]] Vec3<S> vec3_at(const S* xyz) {
  return Eigen::Map<const Vec3<S>>(xyz);
}

/// The array that numpy makes of an argument.
/// @throws InvalidArgument with numpy's own words when it makes none, as of rows of unequal lengths
///         or of a tensor on another device.
[[nodiscard]] inline py::array array_of(const std::string& name, const py::object& values) {
  try {
    return py::module_::import("numpy").attr("asarray")(values);
  } catch (const py::error_already_set& error) {
    if (!error.matches(PyExc_Exception) || error.matches(PyExc_MemoryError)) throw;
    throw InvalidArgument(
        name, py::str(py::type::of(values)),
        "must be an array, its rows equally long (" + std::string(py::str(error.value())) + ")");
  }
}

/// The numbers of an argument as `T`.
/// @param kinds  What they may be, as letters of numpy's `dtype.kind`.
/// @param what   The same in words.
/// @throws InvalidArgument as `array_of`; TypeError when they are of another kind.
template <typename T>
[[nodiscard]] Array<T> numbers_of_kinds(const std::string& name, const py::object& values,
                                        std::string_view kinds, const char* what) {
  const py::array array = array_of(name, values);
  if (kinds.find(array.dtype().kind()) == std::string_view::npos) {
    throw py::type_error(name + ": dtype " + std::string(py::str(array.dtype())) + ": must be " +
                         what);
  }
  return py::array_t<T, py::array::c_style | py::array::forcecast>(array);
}
/// The numbers of an argument in the type of the world.
/// @throws as `numbers_of_kinds`, when they are no real numbers.
template <typename S>
[[nodiscard]] Array<S> numbers_of(const std::string& name, const py::object& values) {
  return numbers_of_kinds<S>(name, values, "fiu", "real numbers");
}
/// Numbers of an argument that count or name things.
/// @throws as `numbers_of_kinds`, when they are no whole numbers.
[[nodiscard]] inline Array<std::int64_t> whole_numbers_of(const std::string& name,
                                                          const py::object& values) {
  return numbers_of_kinds<std::int64_t>(name, values, "iu", "whole numbers");
}

[[nodiscard]] inline std::string shape_text(const std::vector<py::ssize_t>& shape) {
  std::string text;
  for (const py::ssize_t n : shape) text += (text.empty() ? "" : ", ") + std::to_string(n);
  return "(" + text + (shape.size() == 1 ? ",)" : ")");
}
[[nodiscard]] inline bool has_shape(const py::array& array, const std::vector<py::ssize_t>& shape) {
  return array.ndim() == static_cast<py::ssize_t>(shape.size()) &&
         std::equal(shape.begin(), shape.end(), array.shape());
}

/// @throws InvalidArgument when an array is not [some, 3].
inline void require_rows_of_three(const std::string& name, const py::array& rows) {
  if (rows.ndim() == 2 && rows.shape(1) == 3) return;
  throw InvalidArgument(name + ".shape", py::str(rows.attr("shape")), "must be (" + name + ", 3)");
}
/// The points of an argument, [point, 3].
/// @throws as `numbers_of` and `require_rows_of_three`.
template <typename S>
[[nodiscard]] std::vector<Vec3<S>> points_of(const std::string& name, const py::object& values) {
  const Array<S> rows = numbers_of<S>(name, values);
  require_rows_of_three(name, rows);
  std::vector<Vec3<S>> points;
  for (py::ssize_t i = 0; i < rows.shape(0); ++i) points.push_back(vec3_at(rows.data(i, 0)));
  return points;
}

/// Numbers for each of several things, such as the worlds of a batch: a row each, or one row for
/// all.
template <typename S>
class Rows {
 public:
  /// @param count  [-] Number of the things.
  /// @param width  [-] Numbers of a row; 0 for rows that are one number and no array.
  /// @param thing  What they are, in a message.
  /// @throws as `numbers_of`; InvalidArgument when the shape is another.
  Rows(const std::string& name, const py::object& values, std::size_t count, py::ssize_t width = 0,
       const char* thing = "world")
      : numbers_(numbers_of<S>(name, values)) {
    std::vector<py::ssize_t> one;
    if (width > 0) one.push_back(width);
    std::vector<py::ssize_t> all = one;
    all.insert(all.begin(), static_cast<py::ssize_t>(count));
    if (has_shape(numbers_, all)) {
      stride_ = static_cast<std::size_t>(std::max<py::ssize_t>(width, 1));
    } else if (!has_shape(numbers_, one)) {
      throw InvalidArgument(name + ".shape", py::str(numbers_.attr("shape")),
                            "must be " + shape_text(all) + ", a row for each " + thing + ", or " +
                                shape_text(one) + " for all");
    }
  }
  /// First number of the row of a thing.
  [[nodiscard]] const S* operator[](std::size_t number) const {
    return numbers_.data() + number * stride_;
  }

 private:
  Array<S> numbers_;
  std::size_t stride_ = 0;
};

/// Where to write: the array that was given, or a new one of this shape.
template <typename T>
[[nodiscard]] Array<T> out_or_new(const py::object& out, std::vector<py::ssize_t> shape) {
  if (out.is_none()) return Array<T>(std::move(shape));
  const auto dtype = py::dtype::of<T>();
  if (!py::isinstance<py::array>(out)) {
    throw py::type_error("out: " + std::string(py::str(py::type::of(out))) +
                         ": must be an array of numpy");
  }
  const py::array array = out;
  if (!array.dtype().equal(dtype)) {
    throw py::type_error("out: dtype " + std::string(py::str(array.dtype())) + ": must be " +
                         std::string(py::str(py::handle(dtype))));
  }
  if (!has_shape(array, shape)) {
    throw InvalidArgument("out.shape", py::str(array.attr("shape")),
                          "must be " + shape_text(shape));
  }
  if ((array.flags() & py::array::c_style) == 0) {
    throw InvalidArgument("out.flags", "not C-contiguous", "must be C-contiguous");
  }
  if (!array.writeable()) throw InvalidArgument("out.flags", "read-only", "must be writeable");
  return array;
}
template <typename T>
[[nodiscard]] std::span<T> span_of(Array<T>& array) {
  return {array.mutable_data(), static_cast<std::size_t>(array.size())};
}

}  // namespace bristle_python
