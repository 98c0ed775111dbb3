/// @file
/// One shape of each kind, with what is true about it known by other means than the library's.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/shapes/quickhull.hpp>
#include <bristle/geometry/shapes/shapes.hpp>
#include <bristle/geometry/trees/aabb.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

namespace bristle::test {

using namespace bristle::detail;

template <Scalar S>
struct ReferenceShape {
  std::string name;
  Shape<S> shape;
  /// [m] Implicit function of a point: zero on the surface, negative inside, and nowhere steeper
  /// than 1.
  std::function<S(const Vec3<S>&)> level;
  /// [m] Around the shape, exactly; for the half-space around a piece of it.
  Aabb<S> box;
  /// [m] A place on the surface where it is highest, and one well inside.
  Vec3<S> top;
  Vec3<S> inside = Vec3<S>::Zero();
  /// [m] Of the order of the shape's radius.
  S size = S(1);
  bool is_convex = true;
};

/// A closed L of two bars in the x-z plane: from -1 to 1 along x and from 0 to 0.5 along z, and
/// from -1 to -0.5 along x and from 0 to 1.5 along z; from -0.5 to 0.5 along y. In units of `u`.
template <Scalar S>
TriangleMesh<S> l_mesh(S u) {
  // The outline counter-clockwise seen from -y (x to the right, z up).
  const std::vector<Vec2<S>> outline = {{S(-1), S(0)},     {S(1), S(0)},      {S(1), S(0.5)},
                                        {S(-0.5), S(0.5)}, {S(-0.5), S(1.5)}, {S(-1), S(1.5)}};
  TriangleMesh<S> mesh;
  for (const S y : {S(-0.5), S(0.5)}) {
    for (const Vec2<S>& p : outline) mesh.vertices.push_back(u * Vec3<S>(p.x(), y, p.y()));
  }
  for (std::uint32_t i = 0; i < 6; ++i) {
    const std::uint32_t j = (i + 1) % 6;
    mesh.triangles.push_back({i, j + 6, j});
    mesh.triangles.push_back({i, i + 6, j + 6});
  }
  // The end faces from the inner corner, which sees all others.
  for (const std::uint32_t i : {4u, 5u, 0u, 1u}) {
    mesh.triangles.push_back({3, i, (i + 1) % 6});
    mesh.triangles.push_back({9, (i + 1) % 6 + 6, i + 6});
  }
  return mesh;
}

/// Largest distance of a point from the faces of a box, along the axes.
template <Scalar S>
S box_level(const Vec3<S>& p, const Vec3<S>& lower, const Vec3<S>& upper) {
  return std::max((lower - p).maxCoeff(), (p - upper).maxCoeff());
}

/// One shape of each kind, `u` times the size of the first.
template <Scalar S>
std::vector<ReferenceShape<S>> reference_shapes(S u) {
  std::vector<ReferenceShape<S>> all;
  const auto centered = [](const Vec3<S>& half) { return Aabb<S>{-half, half}; };
  const auto up = [](S z) { return Vec3<S>(S(0), S(0), z); };
  {
    const S r = S(0.7) * u;
    all.push_back({"Sphere", Sphere<S>{r}, [=](const Vec3<S>& p) { return p.norm() - r; },
                   centered(Vec3<S>::Constant(r)), up(r)});
  }
  {
    const Vec3<S> h = u * Vec3<S>(S(0.3), S(0.9), S(0.6));
    all.push_back({"Box", Box<S>{h}, [=](const Vec3<S>& p) { return box_level<S>(p, -h, h); },
                   centered(h), Vec3<S>(S(0.1) * u, S(0.2) * u, h.z())});
  }
  {
    const S r = S(0.4) * u;
    const S h = S(0.5) * u;
    all.push_back({"Capsule", Capsule<S>{r, h},
                   [=](const Vec3<S>& p) {
                     return (p - Vec3<S>(S(0), S(0), std::clamp(p.z(), -h, h))).norm() - r;
                   },
                   centered({r, r, h + r}), up(h + r)});
  }
  {
    const S r = S(0.6) * u;
    const S h = S(0.7) * u;
    all.push_back({"Cylinder", Cylinder<S>{r, h},
                   [=](const Vec3<S>& p) {
                     return std::max(std::hypot(p.x(), p.y()) - r, std::abs(p.z()) - h);
                   },
                   centered({r, r, h}), Vec3<S>(S(0.3) * u, S(-0.1) * u, h)});
  }
  {
    const S r = S(0.8) * u;
    const S h = S(0.6) * u;
    // Distance from the side is the horizontal one times the cosine of the side's slope.
    const S cosine = S(2) * h / std::hypot(S(2) * h, r);
    all.push_back({"Cone", Cone<S>{r, h},
                   [=](const Vec3<S>& p) {
                     const S side = std::hypot(p.x(), p.y()) - r * (h - p.z()) / (S(2) * h);
                     return std::max(side * cosine, -h - p.z());
                   },
                   centered({r, r, h}), up(h), up(S(-0.2) * u)});
  }
  {
    const Vec3<S> r = u * Vec3<S>(S(0.4), S(0.8), S(0.6));
    all.push_back(
        {"Ellipsoid", Ellipsoid<S>{r},
         [=](const Vec3<S>& p) { return (p.cwiseQuotient(r).norm() - S(1)) * r.minCoeff(); },
         centered(r), up(r.z())});
  }
  {
    const Vec3<S> n = Vec3<S>(S(1), S(2), S(2)) / S(3);
    const S offset = S(0.3) * u;
    all.push_back({"HalfSpace", HalfSpace<S>{n, offset},
                   [=](const Vec3<S>& p) { return n.dot(p) - offset; },
                   centered(Vec3<S>::Constant(u)), up(S(0.45) * u), up(S(-0.5) * u)});
  }
  {
    // An octahedron: |x| + |y| + |z| <= 0.8.
    const S r = S(0.8) * u;
    std::vector<Vec3<S>> corners;
    for (int i = 0; i < 3; ++i) {
      corners.push_back(r * Vec3<S>::Unit(i));
      corners.push_back(-r * Vec3<S>::Unit(i));
    }
    all.push_back({"ConvexHull", convex_hull<S>(std::span<const Vec3<S>>(corners)),
                   [=](const Vec3<S>& p) { return (p.cwiseAbs().sum() - r) / std::sqrt(S(3)); },
                   centered(Vec3<S>::Constant(r)), up(r)});
  }
  {
    const Vec3<S> low = u * Vec3<S>(S(-1), S(-0.5), S(0));
    const Vec3<S> foot = u * Vec3<S>(S(1), S(0.5), S(0.5));
    const Vec3<S> mast = u * Vec3<S>(S(-0.5), S(0.5), S(1.5));
    all.push_back({"TriangleMesh", l_mesh<S>(u),
                   [=](const Vec3<S>& p) {
                     return std::min(box_level<S>(p, low, foot), box_level<S>(p, low, mast));
                   },
                   Aabb<S>{low, foot.cwiseMax(mast)}, u * Vec3<S>(S(-0.7), S(0.1), S(1.5)),
                   u * Vec3<S>(S(-0.7), S(0.1), S(0.3)), u, false});
  }
  for (ReferenceShape<S>& reference : all) reference.size = u;
  return all;
}

}  // namespace bristle::test
