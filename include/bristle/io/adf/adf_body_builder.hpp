/// @file
/// Converts bodies of an AMBF description to body definitions.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/io/adf/adf_groups.hpp>
#include <bristle/io/adf/adf_meshes.hpp>
#include <bristle/io/adf/adf_model.hpp>
#include <bristle/io/adf/adf_scene.hpp>
#include <bristle/io/adf/adf_solids.hpp>

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <variant>

namespace bristle::inline BRISTLE_ABI::detail {

/// Converts a primitive to the scalar of a world, scaled.
template <Scalar S>
struct ScaledShape {
  S scale;

  Shape<S> operator()(const Sphere<double>& s) const { return Sphere<S>{scale * S(s.radius)}; }
  Shape<S> operator()(const Box<double>& s) const {
    return Box<S>{scale * s.half_extents.template cast<S>()};
  }
  Shape<S> operator()(const HalfSpace<double>& s) const {
    return HalfSpace<S>{s.normal.template cast<S>().normalized(), scale * S(s.offset)};
  }
  /// Capsule, cylinder, cone.
  template <template <typename> typename Solid>
  requires requires(Solid<double> s) { s.half_length; }
  Shape<S> operator()(const Solid<double>& s) const {
    return Solid<S>{scale * S(s.radius), scale * S(s.half_length)};
  }
  /// Descriptions have no other primitives.
  template <typename Other>
  Shape<S> operator()(const Other&) const {
    return Sphere<S>{};
  }
};

/// Converts a pose to the scalar of a world and scales its position. Rotations are unit quaternions
/// and stay so, but for the digits that another scalar drops.
template <Scalar S>
[[nodiscard]] Transform<S> scaled_pose(const Transform<double>& X, double scale) {
  const Quat<S> rotation = X.rotation.cast<S>();
  const Vec3<S> translation = (scale * X.translation).cast<S>();
  if constexpr (std::is_same_v<S, double>) return {rotation, translation};
  return {rotation.normalized(), translation};
}

template <Scalar S>
class AdfBodyBuilder {
 public:
  /// @param gravity  [m/s^2] Gravity of the world.
  /// @param groups   Those of the model are added.
  AdfBodyBuilder(const AdfModel& model, const AdfBuildDef<S>& def, const Vec3<S>& gravity,
                 AdfMeshes<S>& meshes, AdfGroups& groups, AdfReport& report)
      : model_(model),
        def_(def),
        gravity_(gravity),
        meshes_(meshes),
        solids_(model, def.limits, meshes, report),
        groups_(groups),
        report_(report) {
    groups.add(model);
  }

  /// Returns none for a body that is left out, since its mesh is missing.
  [[nodiscard]] std::optional<BodyDef<S>> body(const AdfBody& body) {
    BodyDef<S> result;
    const Transform<S> X_WB = def_.X_WM * scaled_pose<S>(body.location, 1.0);
    result.position = X_WB.translation;
    result.orientation = X_WB.rotation.normalized();
    result.filter = groups_.filter_of(body);
    if (is_without_mesh(body)) {
      if (body.mass > 0.0 && !body.inertia) return std::nullopt;
    } else {
      add_shapes(body, result);
    }
    result.motion = body.mass > 0.0 ? Motion::dynamic : Motion::fixed;
    if (result.motion == Motion::dynamic) set_inertia(body, result);
    result.gravity_scale = gravity_scale(body);
    result.linear_damping = damping_rate(body.linear_damping);
    result.angular_damping = damping_rate(body.angular_damping);
    return result;
  }

 private:
  /// [1/s] Rate at which a part of the velocity is lost in a second: (1 - part)^t is exp(-rate t).
  /// Where all is lost at once, none but round-off is left after a step of the file.
  [[nodiscard]] S damping_rate(double part) const {
    if (part < 1.0) return S(-std::log1p(-part));
    return -std::log(std::numeric_limits<S>::epsilon()) / def_.authored_step;
  }

  /// Bullet multiplies coefficients. Squares give the same for a pair here. For friction that is
  /// exact, as the geometric mean of squares is the product; for restitution, if both are equal.
  [[nodiscard]] static Material<S> material(const AdfBody& body) {
    return {S(body.friction * body.friction), S(body.restitution * body.restitution)};
  }

  void add_shapes(const AdfBody& body, BodyDef<S>& result) {
    for (const AdfShape& shape : body.shapes) {
      result.shapes.push_back({.shape = std::visit(ScaledShape<S>{S(body.scale)}, shape.shape),
                               .X_BS = scaled_pose<S>(shape.X_BS, body.scale),
                               .material = material(body)});
    }
    if (body.shapes.empty() && !body.collision_mesh.empty()) {
      result.shapes.push_back({.shape = solids_.of(body), .material = material(body)});
    }
  }

  /// Returns whether a body goes without its mesh, and reports it.
  [[nodiscard]] bool is_without_mesh(const AdfBody& body) {
    if (!def_.allow_missing_meshes || !body.shapes.empty() || body.collision_mesh.empty()) {
      return false;
    }
    const std::string places = meshes_.missing_from(body.collision_mesh, AdfResolution::low, &body);
    if (places.empty()) return false;
    const bool is_left_out = body.mass > 0.0 && !body.inertia;
    report_.add(is_left_out ? AdfNoteKind::left_out : AdfNoteKind::changed, printable(body.key),
                std::string(is_left_out ? "its inertia is not given, and" : "it has no shape:") +
                    " none of these is a file: " + places,
                body.line);
    return true;
  }

  static void set_inertia(const AdfBody& body, BodyDef<S>& result) {
    result.mass = S(body.mass);
    const bool is_mesh = body.shapes.empty() && !body.collision_mesh.empty();
    if (body.inertial_offset) {
      const Transform<S> X = scaled_pose<S>(*body.inertial_offset, body.scale);
      result.center_of_mass = X.translation;
      if (body.inertia) result.inertia = turned(*body.inertia, X.rotation);
    } else {
      if (!is_mesh) result.center_of_mass = zero<Vec3<S>>();
      if (body.inertia) result.inertia = turned(*body.inertia, Quat<S>::Identity());
    }
  }
  [[nodiscard]] static Mat3<S> turned(const Vec3<double>& moments, const Quat<S>& q) {
    const Mat3<S> R = rotation_matrix<S>(q);
    return R * Vec3<S>(moments.cast<S>()).asDiagonal() * R.transpose();
  }

  /// The world has one gravity, and each body scales it.
  [[nodiscard]] S gravity_scale(const AdfBody& body) {
    const std::optional<Vec3<double>>& wanted = body.gravity ? body.gravity : model_.gravity;
    if (!wanted) return S(1);
    const Vec3<S> g = wanted->template cast<S>();
    const S square = gravity_.squaredNorm();
    const S scale = square > S(0) ? g.dot(gravity_) / square : S(0);
    if (!((g - scale * gravity_).norm() <= Tolerance<S>::equal() * g.norm())) {
      report_.add(AdfNoteKind::changed, "body/gravity",
                  "not along the world's: only the part along it acts", body.line);
    }
    return scale;
  }

  const AdfModel& model_;
  const AdfBuildDef<S>& def_;
  Vec3<S> gravity_;
  AdfMeshes<S>& meshes_;
  AdfSolids<S> solids_;
  const AdfGroups& groups_;
  AdfReport& report_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
