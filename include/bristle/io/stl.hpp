/// @file
/// STL files, binary and ASCII.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/geometry/meshes/mesh_validation.hpp>
#include <bristle/geometry/meshes/triangle_mesh.hpp>
#include <bristle/io/file.hpp>
#include <bristle/io/text_scanner.hpp>
#include <bristle/math/types.hpp>

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

namespace bristle::inline BRISTLE_ABI {

/// Reads a mesh from the bytes of an STL file, binary or ASCII, with equal corners welded.
///
/// The normals in the file are ignored. The order of the corners defines the outside. Triangles
/// keep their order, degenerate ones too. Coordinates are taken as metres.
///
/// @param name  Name of the file, for error messages.
/// @throws IoError that names the line (ASCII) or byte (binary) of an early end, an unexpected
///         word, or a coordinate that is not finite. Also if there is no triangle.
template <Scalar S>
[[nodiscard]] TriangleMesh<S> read_stl(std::string_view bytes, std::string_view name = "STL");

/// Returns the bytes of a binary STL file. Its coordinates are single precision.
///
/// @throws InvalidArgument if the mesh is no valid surface or does not fit single precision.
template <Scalar S>
[[nodiscard]] std::string write_stl(const TriangleMesh<S>& mesh);

/// Writes `write_stl` to a file.
/// @throws IoError if it cannot be written.
template <Scalar S>
void save_stl(const std::string& path, const TriangleMesh<S>& mesh) {
  write_file(path, write_stl(mesh));
}

// Implementation ----------------------------------------------------------------------------------

namespace detail {

/// Layout of binary STL: an 80-byte comment, a count, and 50 bytes for each triangle. Those are 12
/// floats (normal and corners) and 2 unused bytes. All numbers are little-endian.
inline constexpr std::size_t stl_header_size = 84;
inline constexpr std::size_t stl_triangle_size = 50;

[[nodiscard]] inline std::uint32_t get_u32(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    value |= std::uint32_t{static_cast<unsigned char>(bytes[at + i])} << (8 * i);
  }
  return value;
}

inline void put_u32(std::string& bytes, std::uint32_t value) {
  for (unsigned i = 0; i < 4; ++i) bytes.push_back(static_cast<char>(value >> (8 * i) & 0xffu));
}

template <Scalar S>
void append_corner(TriangleMesh<S>& mesh, const Vec3<S>& corner) {
  const auto number = static_cast<std::uint32_t>(mesh.vertices.size());
  if (number % 3 == 0) mesh.triangles.emplace_back();
  mesh.triangles.back()[number % 3] = number;
  mesh.vertices.push_back(corner);
}

/// Reads binary STL. The caller has checked that the size of the file fits its count.
template <Scalar S>
[[nodiscard]] TriangleMesh<S> read_binary_stl(std::string_view bytes, std::string_view name) {
  TriangleMesh<S> mesh;
  const std::uint32_t count = get_u32(bytes, 80);
  mesh.vertices.reserve(3 * std::size_t{count});
  mesh.triangles.reserve(count);
  for (std::size_t t = 0; t < count; ++t) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      Vec3<S> p;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t at = stl_header_size + stl_triangle_size * t + 12 * (corner + 1) + 4 * k;
        const float value = std::bit_cast<float>(get_u32(bytes, at));
        if (!has_finite_square(S(value))) {
          raise(IoError(std::string(name), 0,
                        "byte " + std::to_string(at) + ": coordinate of triangle " +
                            std::to_string(t) + " is not finite"));
        }
        p[static_cast<int>(k)] = S(value);
      }
      append_corner(mesh, p);
    }
  }
  return mesh;
}

/// Reads `solid name { facet normal x y z outer loop { vertex x y z } endloop endfacet } endsolid
/// name`, once or several times. Keywords may be in any case. Line breaks may be anywhere but
/// before a name's end.
template <Scalar S>
class AsciiStlReader {
 public:
  AsciiStlReader(std::string_view text, std::string_view name) : scanner_(text, name) {}

  [[nodiscard]] TriangleMesh<S> read() {
    for (std::string_view word = scanner_.word(); !word.empty(); word = scanner_.word()) {
      require_word(word, "solid");
      scanner_.skip_line();
      read_solid();
      scanner_.skip_line();
    }
    return std::move(mesh_);
  }

 private:
  void read_solid() {
    for (;;) {
      const std::string_view word = scanner_.word();
      if (is_word(word, "endsolid")) return;
      require_word(word, "facet");
      require_word(scanner_.word(), "normal");
      for (int k = 0; k < 3; ++k) {
        if (scanner_.word().empty()) scanner_.fail("file ends within a normal");
      }
      require_word(scanner_.word(), "outer");
      require_word(scanner_.word(), "loop");
      for (int corner = 0; corner < 3; ++corner) {
        require_word(scanner_.word(), "vertex");
        Vec3<S> p;
        for (int k = 0; k < 3; ++k) p[k] = scanner_.template number<S>(scanner_.word());
        append_corner(mesh_, p);
      }
      require_word(scanner_.word(), "endloop");
      require_word(scanner_.word(), "endfacet");
    }
  }

  [[nodiscard]] static bool is_word(std::string_view word, std::string_view keyword) {
    return to_lower(word) == keyword;
  }
  void require_word(std::string_view word, std::string_view keyword) const {
    if (is_word(word, keyword)) return;
    scanner_.fail(TextScanner::quoted(keyword) + " expected, " +
                  (word.empty() ? "but the file ends" : "not " + TextScanner::quoted(word)));
  }

  TextScanner scanner_;
  TriangleMesh<S> mesh_;
};

}  // namespace detail

template <Scalar S>
TriangleMesh<S> read_stl(std::string_view bytes, std::string_view name) {
  const auto fail = [&](const std::string& what) {
    detail::raise(IoError(std::string(name), 0, what));
  };
  if (bytes.empty()) fail("file is empty");
  // Binary files may begin with "solid" as well, so the size decides. For four letters to be the
  // count, a text would have to be longer than 25 GB.
  const bool has_header = bytes.size() >= detail::stl_header_size;
  const std::uint64_t count = has_header ? detail::get_u32(bytes, 80) : 0;
  const std::uint64_t size = detail::stl_header_size + detail::stl_triangle_size * count;

  TriangleMesh<S> mesh;
  if (has_header && bytes.size() == size) {
    mesh = detail::read_binary_stl<S>(bytes, name);
  } else if (detail::to_lower(detail::TextScanner(bytes, name).word()) == "solid") {
    mesh = detail::AsciiStlReader<S>(bytes, name).read();
  } else if (!has_header) {
    fail("byte " + std::to_string(bytes.size()) + ": file ends within the header of 84 bytes");
  } else {
    fail("byte 80: the header announces " + std::to_string(count) + " triangles, which take " +
         std::to_string(size) + " bytes, but the file has " + std::to_string(bytes.size()));
  }
  if (mesh.triangles.empty()) fail("no triangles");
  return weld(mesh);
}

template <Scalar S>
std::string write_stl(const TriangleMesh<S>& mesh) {
  validate_surface(mesh);
  std::string bytes = "STL of bristle";
  bytes.resize(80, ' ');
  detail::put_u32(bytes, static_cast<std::uint32_t>(mesh.triangles.size()));
  const auto put_vector = [&bytes](const Vec3<S>& v) {
    for (int k = 0; k < 3; ++k) {
      const float value = static_cast<float>(v[k]);
      detail::require(std::isfinite(value), "write_stl: coordinate", v[k],
                      "must fit single precision");
      detail::put_u32(bytes, std::bit_cast<std::uint32_t>(value));
    }
  };
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    put_vector(triangle_normal(mesh, t));
    for (const std::uint32_t v : mesh.triangles[t]) put_vector(mesh.vertices[v]);
    bytes.append(2, '\0');
  }
  return bytes;
}

}  // namespace bristle::inline BRISTLE_ABI
