// SPDX-License-Identifier: BSD-3-Clause
#include "support/texts.hpp"

#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/io/stl.hpp>

#include <doctest/doctest.h>

#include <bit>
#include <limits>
#include <string>
#include <support/damage.hpp>
#include <support/random.hpp>
#include <support/rounds.hpp>
#include <support/temp_folder.hpp>

using namespace bristle;
using bristle::test::contains;
using bristle::test::damaged;
using bristle::test::error_of;
using bristle::test::Random;
using bristle::test::rounds;
using bristle::test::TempFolder;

namespace {

const std::string one_facet =
    "solid a part\n"
    "  facet normal 0 0 1\n"
    "    outer loop\n"
    "      vertex 0 0 0\n"
    "      vertex 1.5e0 0 0\n"
    "      vertex 0 +2 -0\n"
    "    endloop\n"
    "  endfacet\n"
    "endsolid a part\n";

template <typename S>
std::string stl_error(const std::string& bytes) {
  return error_of<IoError>([&] { (void)read_stl<S>(bytes, "part.stl"); });
}
std::string replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

void set_float(std::string& bytes, std::size_t at, float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  for (unsigned i = 0; i < 4; ++i) bytes[at + i] = static_cast<char>(bits >> (8 * i) & 0xffu);
}

}  // namespace

TEST_CASE_TEMPLATE("write_stl, read_stl: bring back a mesh", S, float, double) {
  // Coordinates that single precision holds exactly.
  const TriangleMesh<S> mesh = box_mesh<S>({S(0.5), S(1.25), S(3)});
  const std::string bytes = write_stl(mesh);
  CHECK(bytes.size() == 84 + 50 * 12);
  const TriangleMesh<S> read = read_stl<S>(bytes);
  CHECK_NOTHROW(validate_solid(read));
  REQUIRE(read.vertices.size() == 8);
  REQUIRE(read.triangles.size() == 12);
  for (std::size_t t = 0; t < 12; ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      CHECK(read.vertices[read.triangles[t][k]] == mesh.vertices[mesh.triangles[t][k]]);
    }
  }
}

TEST_CASE_TEMPLATE("read_stl: takes a binary file that begins with the word solid", S, float,
                   double) {
  std::string bytes = write_stl(box_mesh<S>({1, 1, 1}));
  bytes.replace(0, 6, "solid ");
  CHECK(read_stl<S>(bytes).triangles.size() == 12);
}

TEST_CASE_TEMPLATE("read_stl: reads ASCII in any case, spacing and line end", S, float, double) {
  std::string crlf;
  std::string upper;
  std::string packed;
  for (const char c : one_facet) {
    crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
    upper += c >= 'a' && c <= 'z' && c != 'e' ? static_cast<char>(c - 'a' + 'A') : c;
    packed += c;
  }
  packed = replaced(packed, "outer loop\n", "outer loop ");
  for (const std::string& text : {one_facet, crlf, upper, packed, "\n  " + one_facet,
                                  replaced(one_facet, "normal 0 0 1", "normal nan nan nan")}) {
    CAPTURE(text);
    const TriangleMesh<S> mesh = read_stl<S>(text);
    REQUIRE(mesh.triangles.size() == 1);
    REQUIRE(mesh.vertices.size() == 3);
    CHECK(mesh.vertices[1] == Vec3<S>(S(1.5), 0, 0));
    CHECK(mesh.vertices[2] == Vec3<S>(0, 2, 0));
  }
  // Two solids in one file; their common corners are welded.
  CHECK(read_stl<S>(one_facet + one_facet).triangles.size() == 2);
  CHECK(read_stl<S>(one_facet + one_facet).vertices.size() == 3);
}

TEST_CASE_TEMPLATE("read_stl: names the line where ASCII goes wrong", S, float, double) {
  CHECK(contains(stl_error<S>(replaced(one_facet, "1.5e0", "nan")), "part.stl:5: 'nan'"));
  CHECK(contains(stl_error<S>(replaced(one_facet, "1.5e0", "1,5")), "part.stl:5: '1,5'"));
  CHECK(contains(stl_error<S>(replaced(one_facet, "1.5e0", "1e999")), "part.stl:5"));
  CHECK(contains(stl_error<S>(replaced(one_facet, "outer", "inner")),
                 "part.stl:3: 'outer' expected, not 'inner'"));
  CHECK(contains(stl_error<S>(replaced(one_facet, "    endloop\n", "    vertex 0 0 0\n")),
                 "part.stl:7: 'endloop' expected"));
  CHECK(contains(stl_error<S>(one_facet + "rubbish"), "'solid' expected, not 'rubbish'"));
  CHECK(contains(stl_error<S>("solid empty\nendsolid empty\n"), "no triangles"));
  // Cut short anywhere before the last word, it is an error and never a smaller mesh.
  const std::size_t last_word = one_facet.rfind("endsolid") + 8;
  for (std::size_t size = 0; size < last_word; ++size) {
    CAPTURE(size);
    CHECK(stl_error<S>(one_facet.substr(0, size)) != "");
  }
}

TEST_CASE_TEMPLATE("read_stl: names the byte where binary goes wrong", S, float, double) {
  const std::string good = write_stl(box_mesh<S>({1, 1, 1}));
  CHECK(stl_error<S>("") == "part.stl: file is empty");
  CHECK(contains(stl_error<S>(good.substr(0, 50)), "byte 50: file ends within the header"));
  for (std::size_t size = 84; size < good.size(); ++size) {
    CAPTURE(size);
    CHECK(contains(stl_error<S>(good.substr(0, size)), "announces 12 triangles"));
  }
  CHECK(contains(stl_error<S>(good + "x"), "the file has 685"));
  std::string bytes = good;
  // The second corner's y of triangle 3: header, triangles, normal and one corner before it.
  const std::size_t at = 84 + 3 * 50 + 12 + 12 + 4;
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), infinity<float>}) {
    set_float(bytes, at, bad);
    CHECK(contains(stl_error<S>(bytes), "byte " + std::to_string(at)));
    CHECK(contains(stl_error<S>(bytes), "triangle 3"));
  }
  bytes = good;
  set_float(bytes, 84 + 4, std::numeric_limits<float>::quiet_NaN());  // a normal: not used
  CHECK(stl_error<S>(bytes) == "");
}

TEST_CASE_TEMPLATE("read_stl: an absurd count is an error, not an allocation", S, float, double) {
  std::string bytes = write_stl(box_mesh<S>({1, 1, 1}));
  bytes.replace(80, 4, "\xff\xff\xff\xff");
  CHECK(contains(stl_error<S>(bytes), "announces 4294967295 triangles, which take 214748364834"));
  bytes.replace(80, 4, std::string(4, '\0'));
  CHECK(contains(stl_error<S>(bytes), "announces 0 triangles"));
  CHECK(contains(stl_error<S>(bytes.substr(0, 84)), "no triangles"));
}

TEST_CASE_TEMPLATE("read_stl: keeps degenerate triangles for others to report", S, float, double) {
  const std::string text = replaced(one_facet, "vertex 0 +2 -0", "vertex 0 0 0");
  const TriangleMesh<S> mesh = read_stl<S>(text);
  CHECK(mesh.triangles.size() == 1);
  CHECK(degenerate_triangles(mesh).size() == 1);
}

TEST_CASE_TEMPLATE("read_stl: damaged files end in IoError or a mesh, never otherwise", S, float,
                   double) {
  const std::uint64_t seed = 47;
  CAPTURE(seed);
  Random random(seed);
  const std::string originals[] = {one_facet + one_facet, write_stl(box_mesh<S>({1, 1, 1}))};
  constexpr const char* words[] = {"facet ", "vertex ", "endloop", "endsolid",
                                   "solid ", "1e999 ",  "nan ",    "-1 "};
  int errors = 0;
  for (int round = 0; round < rounds(3000); ++round) {
    CAPTURE(round);
    const std::string bytes = damaged(originals[random.index(2)], random, words);
    try {
      const TriangleMesh<S> mesh = read_stl<S>(bytes);
      CHECK_NOTHROW(validate_surface(mesh));
      CHECK(mesh.triangles.size() <= bytes.size() / 50);
    } catch (const IoError&) {
      ++errors;
    }
  }
  CHECK(errors > rounds(1000));
}

TEST_CASE_TEMPLATE("save_stl: writes what write_stl makes and refuses what is no mesh", S, float,
                   double) {
  const TriangleMesh<S> mesh = sphere_mesh(S(0.5), 2);
  const TempFolder folder;
  const auto path = folder.path() / "mesh.stl";
  save_stl(path, mesh);
  CHECK(read_file(path) == write_stl(mesh));
  CHECK_THROWS_AS(save_stl(path / "none.stl", mesh), IoError);
  CHECK_THROWS_AS((void)write_stl(TriangleMesh<S>{}), InvalidArgument);
}

TEST_CASE("write_stl: refuses coordinates beyond single precision") {
  TriangleMesh<double> mesh = box_mesh<double>({1, 1, 1});
  mesh.vertices[3].x() = 1e60;
  CHECK_THROWS_AS((void)write_stl(mesh), InvalidArgument);
}
