// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"
#include "support/texts.hpp"

#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/geometry/shapes/quickhull.hpp>
#include <bristle/io/mesh_file.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <support/temp_folder.hpp>
#include <vector>

using namespace bristle;
using bristle::test::error_of;
using bristle::test::TempFolder;
namespace fs = std::filesystem;

namespace {

std::string loading_error(const fs::path& path) {
  return error_of<IoError>([&] { (void)load_mesh<double>(path); });
}

/// Folder with meshes of the reference implementation; empty where this machine has none.
fs::path reference_meshes() {
  const char* shared = std::getenv("BRISTLE_SHARED");
  const fs::path root = shared != nullptr ? fs::path(shared)
                                          : fs::path(__FILE__).parent_path() / "../../../../shared";
  std::error_code error;
  return fs::is_directory(root / "ambf", error) ? root / "ambf" : fs::path();
}

std::vector<fs::path> mesh_files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string extension = detail::to_lower(entry.path().extension().string());
    if (extension == ".stl" || extension == ".obj") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

TEST_CASE_TEMPLATE("load_mesh: tells kinds apart by extension, in whatever case", S, float,
                   double) {
  const TempFolder temp;
  const fs::path& folder = temp.path();
  const TriangleMesh<S> box = box_mesh<S>({1, 2, 3});
  for (const char* name : {"box.stl", "box.STL", "box.obj", "a.b.Obj"}) {
    CAPTURE(name);
    const bool is_stl = detail::to_lower(fs::path(name).extension().string()) == ".stl";
    is_stl ? save_stl(folder / name, box) : save_obj(folder / name, box);
    const TriangleMesh<S> read = load_mesh<S>(folder / name);
    CHECK_NOTHROW(validate_solid(read));
    CHECK(signed_volume(read) == test::relative(48.0));
  }
}

TEST_CASE("load_mesh: names the file in every error") {
  const TempFolder temp;
  const fs::path& folder = temp.path();
  fs::create_directories(folder / "folder.stl");
  write_file(folder / "empty.stl", "");
  write_file(folder / "empty.obj", "");
  write_file(folder / "bad.obj", "v 0 0 0\nv 1 x 0\n");
  write_file(folder / "mesh.ply", "ply");
  const auto check = [&](const char* name, const std::string& what) {
    CHECK(loading_error(folder / name) == (folder / name).string() + what);
  };
  check("none.obj", ": cannot be opened for reading: No such file or directory");
  // What tells a folder depends on the file system.
  const std::string place = (folder / "folder.stl").string();
  CHECK(loading_error(place).starts_with(place + ": "));
  check("empty.stl", ": file is empty");
  check("empty.obj", ": file is empty");
  check("bad.obj", ":2: 'x' is not a finite number");
  check("mesh.ply", ": unknown kind of mesh file (known: .stl, .obj)");
  check("", ": unknown kind of mesh file (known: .stl, .obj)");
}

TEST_CASE_TEMPLATE("load_mesh: reads the meshes of the reference implementation", S, float,
                   double) {
  const fs::path folder = reference_meshes();
  if (folder.empty()) {
    MESSAGE("skipped: no reference meshes (set BRISTLE_SHARED to the folder that holds ambf/)");
    return;
  }
  int solids = 0;
  for (const fs::path& path : mesh_files_in(folder)) {
    CAPTURE(path.string());
    if (fs::file_size(path) == 84) {  // an STL with a header and nothing else
      CHECK(loading_error(path).find("no triangles") != std::string::npos);
      continue;
    }
    const TriangleMesh<S> mesh = load_mesh<S>(path);
    CHECK_NOTHROW(validate_surface(mesh));
    CHECK(degenerate_triangles(mesh).empty());
    try {
      validate_solid(mesh);
    } catch (const InvalidArgument& error) {
      // Patches of sensors are open, and so are a few of the parts.
      CHECK(std::string(error.what()).find("open mesh") != std::string::npos);
      continue;
    }
    ++solids;
    CHECK_NOTHROW(convex_hull(mesh).validate());
  }
  CHECK(solids > 0);
}
