/// @file
/// The pad of pad_workload.hpp as a patch: its rays and its law, and what they should give.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "benchmarks/pad_workload.hpp"
#include "support/scalar_patch.hpp"

#include <bristle/math/rotation.hpp>
#include <bristle/sensors/patch_contacts.hpp>
#include <bristle/sensors/patch_explicit.hpp>
#include <bristle/sensors/sensor_wrench.hpp>
#include <bristle/sensors/tuning.hpp>

#include <cstddef>
#include <utility>
#include <vector>

namespace bristle::benchmarks {

using namespace bristle::detail;

/// [s] Of the pad's motion.
inline constexpr double pad_time_step = 1e-3;

/// The object as a moving body, in the pad's frame.
template <Scalar S>
[[nodiscard]] Body<S> object_body(const Object& object, int step, double gap) {
  const Transform<double> now = object.pose(step, gap);
  const Transform<double> then = object.pose(step + 1, gap);
  const Vec3<double> turn =
      log_rotation<double>((then.rotation * now.rotation.conjugate()).normalized());
  Body<S> body;
  body.center_pose = now.template cast<S>();
  body.twist = {((then.translation - now.translation) / pad_time_step).template cast<S>(),
                (turn / pad_time_step).template cast<S>()};
  return body;
}

/// A patch that stands still in the origin, with what is needed to let it sense one body.
template <Scalar S>
class PadPatch {
 public:
  PadPatch(const SensorLayout<double>& layout, Integration integration) {
    PatchDef<S> def;
    def.sensors = layout_as<S>(layout);
    def.parameters = tuned_for<S>({.load = S(20), .mass = S(2)}).parameters(def.sensors);
    def.integration = integration;
    patch = make_patch<S>(std::move(def), BodyId{0, 0}, Vec3<S>(Vec3<S>::Zero()));
    scratch.begin(patch);
    scratch.list_all();
    moving_.inverse_mass.setConstant(S(0.5));
    moving_.inverse_inertia = Mat3<S>::Identity() * S(100);
  }

  /// The batch a world casts: implicit patches look as far as the body comes within the step.
  [[nodiscard]] RayBatch<S> rays(const Body<S>& body) {
    RayBatch<S> batch = patch.geometry->rays(S(0));
    batch.triangle_cache = &patch.triangle_cache;
    if (patch.def.integration == Integration::explicit_) return batch;
    const Vec3<S> center = patch.geometry->box.center();
    const Vec3<S> v = body.twist.at(center - body.center_pose.translation);
    batch.extra_length =
        S(pad_time_step) *
        (v.norm() + body.twist.angular.norm() * patch.geometry->box.half_extents().norm());
    return batch;
  }

  /// From hits to contacts.
  void meet(const Body<S>& body) {
    collect_contacts(patch, scratch, pad_,
                     [&](std::uint32_t) {
                       return TouchedBody<S>{&body, body_id};
                     },
                     {.dt = S(pad_time_step), .measures_lambda = false, .only_tag = 0});
  }

  /// [N s, N m s] Sum of the impulses on the body that was met: at the start of the step, or of
  /// linear models at the motion of the start. Further passes are left out: their cost depends on
  /// the scene.
  Wrench<S> respond() {
    const S dt = S(pad_time_step);
    if (scratch.pairs.empty()) return {};
    PatchPair<S>& pair = scratch.pairs[0];
    if (patch.def.integration == Integration::explicit_) {
      return explicit_impulses(patch, scratch, pair, body_id, dt);
    }
    measure_pair(patch, pair, fixed_, moving_, dt);
    start_linearisation(patch, scratch, pair, dt);
    fill_block(pair, block_);
    return evaluate(patch, scratch, pair, motion(pair), dt, {}).impulse;
  }

  /// The motion at the start of the step about c; the pad's axes are the world's.
  [[nodiscard]] static Vec6<S> motion(const PatchPair<S>& pair) {
    Vec6<S> u;
    u << pair.start_motion.at(pair.center), pair.start_motion.angular;
    return u;
  }

  static constexpr BodyId body_id{1, 0};
  SensorPatch<S> patch;
  PatchScratch<S> scratch;

 private:
  Body<S> pad_;
  SolverBody<S> fixed_, moving_;
  SoftBlock<S> block_;
};

/// Reference of the first steps: each ray by itself, each sensor by itself, in double.
struct PadReference {
  static constexpr int steps = 6;

  PadReference(const Object& object, const Reference& reference, const SensorLayout<double>& layout,
               double gap) {
    PadPatch<double> by_force(layout, Integration::explicit_);
    PadPatch<double> by_model(layout, Integration::implicit);
    std::vector<SensorMemory<double>> memory(layout.size());
    for (int k = 0; k < steps; ++k) {
      const Body<double> body = object_body<double>(object, k, gap);
      const double reach = by_model.rays(body).extra_length;
      std::vector<double> found(layout.size());
      RayHits<double>& hits = by_model.scratch.hits;
      by_model.scratch.reset_near_hits();
      Wrench<double> force;
      for (std::size_t i = 0; i < layout.size(); ++i) {
        const Ray<double> ray{layout.start[i], layout.direction[i], layout.length[i]};
        const RayHit<double> hit = reference.hit(body.center_pose, ray);
        found[i] = hit.distance;
        if (hit.distance <= ray.length + reach) hits.offer(i, hit, 0);
        force += -sensor_wrench<double>(by_force.patch.def.parameters, by_force.patch.def.options,
                                        ray, hit.distance, hit.normal, {}, {}, body.center_pose,
                                        body.twist, pad_time_step, memory[i]);
      }
      distances.push_back(std::move(found));
      explicit_impulse.push_back(pad_time_step * force.force);
      by_model.meet(body);
      (void)by_model.respond();
      const PatchPair<double>& pair = by_model.scratch.pairs[0];
      implicit_impulse.push_back(
          test::scalar_block_impulse<double>(by_model.patch, by_model.scratch, pair,
                                             PadPatch<double>::motion(pair), pad_time_step)
              .force);
    }
  }

  /// [m] For each step, of each ray, however far.
  std::vector<std::vector<double>> distances;
  /// [N s] For each step, on the body.
  std::vector<Vec3<double>> explicit_impulse, implicit_impulse;
};

}  // namespace bristle::benchmarks
