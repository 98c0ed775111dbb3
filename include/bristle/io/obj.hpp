/// @file
/// Wavefront OBJ files: their vertices and faces.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/geometry/meshes/mesh_validation.hpp>
#include <bristle/geometry/meshes/triangle_mesh.hpp>
#include <bristle/io/file.hpp>
#include <bristle/io/text_scanner.hpp>
#include <bristle/math/types.hpp>

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// Reads a mesh from the text of an OBJ file.
///
/// Reads `v` and `f`. Everything else is ignored. Faces may have numbers of texture coordinates and
/// normals. Numbers count from the start or (negative) from the end. Faces with more than three
/// corners become a fan around their first, which suits convex ones. Vertices keep their numbers.
/// Files that repeat them along seams need `weld`. Coordinates are taken as metres.
///
/// @param name  Name of the file, for error messages.
/// @throws IoError that names the line with a coordinate that is not a finite number, or a face
///         with fewer than three corners or a vertex that is not defined above it. Also if there is
///         no face at all.
template <Scalar S>
[[nodiscard]] TriangleMesh<S> read_obj(std::string_view text, std::string_view name = "OBJ");

/// Returns the text of an OBJ file. Its numbers read back as the same bits.
///
/// @throws InvalidArgument if the mesh is no valid surface.
template <Scalar S>
[[nodiscard]] std::string write_obj(const TriangleMesh<S>& mesh);

/// Writes `write_obj` to a file.
/// @throws IoError if it cannot be written.
template <Scalar S>
void save_obj(const std::string& path, const TriangleMesh<S>& mesh) {
  write_file(path, write_obj(mesh));
}

// Implementation ----------------------------------------------------------------------------------

namespace detail {

template <Scalar S>
class ObjReader {
 public:
  ObjReader(std::string_view text, std::string_view name) : scanner_(text, name) {}

  [[nodiscard]] TriangleMesh<S> read() {
    for (std::string_view word = scanner_.word(); !word.empty(); word = scanner_.word()) {
      if (word == "v") read_vertex();
      if (word == "f") read_face();
      scanner_.skip_line();
    }
    if (mesh_.triangles.empty()) scanner_.fail("no faces");
    return std::move(mesh_);
  }

 private:
  /// Next word of the statement. Empty at the end of the line or at a comment.
  [[nodiscard]] std::string_view word() {
    const std::string_view word = scanner_.word_on_line();
    return word.starts_with('#') ? std::string_view() : word;
  }

  void read_vertex() {
    Vec3<S> p;
    for (int k = 0; k < 3; ++k) p[k] = scanner_.template number<S>(word());
    mesh_.vertices.push_back(p);
  }

  void read_face() {
    corners_.clear();
    for (std::string_view w = word(); !w.empty(); w = word()) corners_.push_back(vertex_number(w));
    if (corners_.size() < 3) {
      scanner_.fail("face with " + std::to_string(corners_.size()) + " corners");
    }
    for (std::size_t i = 2; i < corners_.size(); ++i) {
      mesh_.triangles.push_back({corners_[0], corners_[i - 1], corners_[i]});
    }
  }

  /// Parses v, v/vt, v//vn or v/vt/vn, and returns v.
  [[nodiscard]] std::uint32_t vertex_number(std::string_view word) const {
    std::string_view rest = word;
    const long long number = take_integer(rest, word);
    for (int part = 0; part < 2 && rest.starts_with('/'); ++part) {
      rest.remove_prefix(1);
      if (!rest.empty() && !rest.starts_with('/')) (void)take_integer(rest, word);
    }
    if (!rest.empty()) fail_reference(word, "is not of the form v/vt/vn");

    const auto count = static_cast<long long>(mesh_.vertices.size());
    if (number == 0) fail_reference(word, "names vertex 0, but they count from 1");
    if (number > count || number < -count) {
      fail_reference(word, "names a vertex that is not among the " + std::to_string(count) +
                               " defined so far");
    }
    return static_cast<std::uint32_t>(number > 0 ? number - 1 : count + number);
  }

  [[nodiscard]] long long take_integer(std::string_view& rest, std::string_view word) const {
    long long value = 0;
    const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
    if (error != std::errc{}) fail_reference(word, "is not of the form v/vt/vn");
    rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
    return value;
  }

  [[noreturn]] void fail_reference(std::string_view word, const std::string& what) const {
    scanner_.fail("corner " + TextScanner::quoted(word) + " " + what);
  }

  TextScanner scanner_;
  TriangleMesh<S> mesh_;
  std::vector<std::uint32_t> corners_;
};

}  // namespace detail

template <Scalar S>
TriangleMesh<S> read_obj(std::string_view text, std::string_view name) {
  if (text.empty()) detail::raise(IoError(std::string(name), 0, "file is empty"));
  return detail::ObjReader<S>(text, name).read();
}

template <Scalar S>
std::string write_obj(const TriangleMesh<S>& mesh) {
  validate_surface(mesh);
  std::string text = "# OBJ of bristle\n";
  for (const Vec3<S>& v : mesh.vertices) {
    text += 'v';
    for (int k = 0; k < 3; ++k) {
      // The shortest text of a double has at most 24 characters.
      char digits[64];
      const auto result = std::to_chars(digits, digits + sizeof digits, v[k]);
      text += ' ';
      text.append(digits, result.ptr);
    }
    text += '\n';
  }
  for (const auto& t : mesh.triangles) {
    text += 'f';
    for (const std::uint32_t v : t) text += ' ' + std::to_string(std::uint64_t{v} + 1);
    text += '\n';
  }
  return text;
}

}  // namespace bristle::inline BRISTLE_ABI
