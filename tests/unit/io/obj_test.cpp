// SPDX-License-Identifier: BSD-3-Clause
#include "support/texts.hpp"

#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/io/obj.hpp>

#include <doctest/doctest.h>

#include <array>
#include <limits>
#include <string>
#include <support/damage.hpp>
#include <support/random.hpp>
#include <support/rounds.hpp>
#include <support/temp_folder.hpp>

using namespace bristle;

using namespace bristle::detail;
using bristle::test::contains;
using bristle::test::damaged;
using bristle::test::error_of;
using bristle::test::Random;
using bristle::test::rounds;
using bristle::test::TempFolder;

namespace {

using Corners = std::array<std::uint32_t, 3>;

const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

template <typename S>
std::string obj_error(const std::string& text) {
  return error_of<IoError>([&] { (void)read_obj<S>(text, "part.obj"); });
}

}  // namespace

TEST_CASE_TEMPLATE("read_obj: reads every form of a face", S, float, double) {
  for (const std::string face :
       {"f 1 2 3", "f 1/1 2/2 3/3", "f 1//1 2//1 3//1", "f 1/1/1 2/2/1 3/3/1", "f 1/ 2/ 3/",
        "f -4 -3 -2", "f -4/1/1 2/-1/1 -2//-1", "  f\t1 2\\\n 3", "f 1 2 3 # a comment",
        "f 1 2 3\r"}) {
    CAPTURE(face);
    const TriangleMesh<S> mesh = read_obj<S>(square + face + "\n");
    REQUIRE(mesh.triangles.size() == 1);
    CHECK(mesh.triangles[0] == Corners{0, 1, 2});
    CHECK(mesh.vertices.size() == 4);
    // The last line needs no end.
    CHECK(read_obj<S>(square + face).triangles.size() == 1);
  }
}

TEST_CASE_TEMPLATE("read_obj: cuts polygons into a fan", S, float, double) {
  const TriangleMesh<S> mesh = read_obj<S>(square + "v 0 0.5 0\nf 2 3 4 5 1\n");
  REQUIRE(mesh.triangles.size() == 3);
  CHECK(mesh.triangles[0] == Corners{1, 2, 3});
  CHECK(mesh.triangles[1] == Corners{1, 3, 4});
  CHECK(mesh.triangles[2] == Corners{1, 4, 0});
}

TEST_CASE_TEMPLATE("read_obj: ignores what is not geometry", S, float, double) {
  const std::string text =
      "# a file\r\nmtllib a.mtl\r\no thing\r\ng part 1\r\nv 0 0 0 1.0\r\nv 1 0 0 0.5 0.5 0.5\r\n"
      "v 0 1.5e0 -0.25\r\nvt 0 0\r\nvn 0 0 1\r\ns off\r\nusemtl \xff\r\nl 1 2\r\nvp 1\r\n"
      "unheard-of nan\r\nf 1/1/1 2/1/1 3/1/1\r\n";
  const TriangleMesh<S> mesh = read_obj<S>(text);
  REQUIRE(mesh.vertices.size() == 3);
  CHECK(mesh.vertices[2] == Vec3<S>(0, S(1.5), S(-0.25)));
  REQUIRE(mesh.triangles.size() == 1);
}

TEST_CASE_TEMPLATE("read_obj: negative numbers count back from the face", S, float, double) {
  const TriangleMesh<S> mesh =
      read_obj<S>("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 0 0 1\nf -1 -3 -2\n");
  REQUIRE(mesh.triangles.size() == 2);
  CHECK(mesh.triangles[0] == Corners{0, 1, 2});
  CHECK(mesh.triangles[1] == Corners{3, 1, 2});
}

TEST_CASE_TEMPLATE("read_obj: names the line at fault", S, float, double) {
  CHECK(obj_error<S>("") == "part.obj: file is empty");
  CHECK(contains(obj_error<S>(square), "no faces"));
  CHECK(contains(obj_error<S>(square + "f 1 2 0\n"), "part.obj:5: corner '0' names vertex 0"));
  CHECK(contains(obj_error<S>(square + "f 1 2 5\n"), "part.obj:5: corner '5' names a vertex"));
  CHECK(contains(obj_error<S>(square + "f 1 2 -5\n"), "not among the 4 defined so far"));
  CHECK(contains(obj_error<S>(square + "f 1 2 99999999999999999999\n"), "part.obj:5: corner"));
  CHECK(contains(obj_error<S>(square + "f 1 2\n"), "part.obj:5: face with 2 corners"));
  CHECK(contains(obj_error<S>(square + "f\n"), "face with 0 corners"));
  for (const std::string corner : {"x", "1x", "1/x", "1/2/3/4", "/1", "1//x", "1.5", "1-2"}) {
    CAPTURE(corner);
    CHECK(contains(obj_error<S>(square + "f 1 2 " + corner + "\n"), "is not of the form"));
  }
  CHECK(contains(obj_error<S>("v 0 0\nv 1 1 1\n"), "part.obj:1: number missing"));
  CHECK(contains(obj_error<S>("\n\nv 0 nan 0\n"), "part.obj:3: 'nan' is not a finite number"));
  CHECK(contains(obj_error<S>("v 0 1,5 0\n"), "'1,5'"));
  CHECK(contains(obj_error<S>("v 0 1e999 0\n"), "part.obj:1"));
  CHECK(contains(obj_error<S>("v 0 0 # 0\n"), "number missing"));
}

TEST_CASE_TEMPLATE("write_obj, read_obj: bring back the same bits", S, float, double) {
  const std::uint64_t seed = 53;
  CAPTURE(seed);
  Random random(seed);
  TriangleMesh<S> mesh = sphere_mesh(S(0.1), 3);
  for (auto& v : mesh.vertices) v += random.in_cube(S(1e-3));
  mesh.vertices.push_back({std::numeric_limits<S>::min(), largest_number<S>, S(-0.1)});
  const TriangleMesh<S> read = read_obj<S>(write_obj(mesh));
  CHECK(read.vertices == mesh.vertices);
  CHECK(read.triangles == mesh.triangles);
  CHECK_THROWS_AS((void)write_obj(TriangleMesh<S>{}), InvalidArgument);

  const TempFolder folder;
  const auto path = folder.path() / "mesh.obj";
  save_obj(path, mesh);
  CHECK(read_file(path) == write_obj(mesh));
  CHECK_THROWS_AS(save_obj(path / "none.obj", mesh), IoError);
}

TEST_CASE_TEMPLATE("read_obj: damaged files end in IoError or a mesh, never otherwise", S, float,
                   double) {
  const std::uint64_t seed = 59;
  CAPTURE(seed);
  Random random(seed);
  const std::string original = square + "vn 0 0 1\nf 1//1 2//1 3//1\nf -4/1 3 \\\n4 2\n# end\n";
  constexpr const char* words[] = {"v ", "f ",  "vn ",    "/",    "\\\n",
                                   "#",  "-1 ", "1e999 ", "nan ", "\x7f"};
  int errors = 0;
  for (int round = 0; round < rounds(5000); ++round) {
    CAPTURE(round);
    const std::string text = damaged(original, random, words);
    try {
      const TriangleMesh<S> mesh = read_obj<S>(text);
      CHECK_NOTHROW(validate_surface(mesh));
      CHECK(mesh.triangles.size() <= text.size() / 2);
    } catch (const IoError&) {
      ++errors;
    }
  }
  CHECK(errors > rounds(1000));
}
