/// @file
/// Bytes as calls of a `World`, in any order and with any numbers, among which `world_oracles.hpp`
/// looks at it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "fuzz/fuzz_defs.hpp"
#include "fuzz/world_oracles.hpp"

#include <bristle/bristle.hpp>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace bristle::test {

using namespace bristle::detail;

/// Counts of one script.
struct ScriptCounts {
  std::size_t calls = 0;
  std::size_t refused = 0;
  std::size_t steps = 0;
};

/// One run of a script.
/// @tparam S        float or double.
/// @tparam Backend  Either.
template <typename S, typename Backend>
class WorldScript {
 public:
  explicit WorldScript(std::span<const std::uint8_t> bytes) : in_(bytes) {}

  /// @throws Finding for what must not happen.
  ScriptCounts run() {
    start();
    while (!in_.at_end() && counts_.calls < most_calls) next_call();
    for (int i = 0; i < 3; ++i) step();
    for (const BodyId id : bodies_) world_->remove_body(id);
    look_at_emptied(*world_);
    return counts_;
  }

 private:
  using World = bristle::World<S, Backend>;
  using Loop = HapticLoop<S>;

  // Enough to meet in all ways, few enough for some hundred scripts in a second.
  static constexpr std::size_t most_calls = 200;
  static constexpr std::size_t most_steps = 60;
  static constexpr std::size_t most_bodies = 12;
  static constexpr std::size_t most_joints = 12;
  static constexpr std::size_t most_patches = 4;

  // Calls

  template <typename Call>
  bool call(const char* name, const Call& make) {
    ++counts_.calls;
    const bool is_accepted = accepts(*world_, name, make);
    if (!is_accepted) ++counts_.refused;
    return is_accepted;
  }

  void start() {
    WorldDef<S> def;
    const std::uint8_t kind = in_.byte();
    // Half of the scripts have bodies that meet, and half are refused half of what they ask.
    if ((kind & 32) != 0) in_.be_tame();
    if ((kind & 1) != 0) def.sleep.time = S(0.05);
    if ((kind & 2) != 0) def.integrator = Integrator::symplectic_euler;
    if ((kind & 4) != 0) {
      def.solver.max_direct_work = std::uint64_t{in_.byte()} << 8;
      def.solver.max_sweeps = 1 + static_cast<int>(in_.choice(20));
    }
    if ((kind & 64) != 0) {
      def.keeps_contact_events = true;
      def.may_collide = [](std::uint64_t a, std::uint64_t b) { return a != 3 || b != 3; };
      def.combine = [](const Material<S>& a, const Material<S>& b) {
        return Material<S>{.friction = a.friction * b.friction};
      };
    }
    world_.emplace(def);
    if ((kind & 8) == 0) {
      BodyDef<S> floor;
      floor.motion = Motion::fixed;
      floor.shape = HalfSpace<S>{};
      bodies_.push_back(world_->add_body(floor));
    }
    if ((kind & 16) == 0) return;
    (void)call("World", [&] {
      def.gravity = in_.vector(S(10));
      def.time_step = in_.positive(S(0.02));
      def.restitution_speed = in_.positive(S(0.1));
      def.solver.longest_substep = in_.positive(S(0.02));
      (void)World(def);
    });
  }

  void change_body() {
    const BodyId id = body();
    switch (in_.choice(3)) {
      case 0:
        (void)call("wake", [&] { world_->wake(id); });
        return;
      case 1:
        (void)call("set_mass", [&] { world_->set_mass(id, in_.positive(S(1))); });
        return;
      default:
        (void)call("set_material", [&] { world_->set_material(id, in_.material()); });
    }
  }

  void next_call() {
    switch (in_.choice(30)) {
      case 0:
      case 1:
      case 2:
        return add_body();
      case 3:
        return remove_body();
      case 4:
        (void)call("add_shape",
                   [&] { shapes_.push_back(world_->add_shape(body(), in_.shape_def())); });
        return;
      case 5:
        (void)call("remove_shape", [&] { world_->remove_shape(one_of(shapes_)); });
        return;
      case 6:
      case 7:
        return add_joint();
      case 8:
        (void)call("remove_joint", [&] { world_->remove_joint(one_of(joints_)); });
        return;
      case 9:
        (void)call("set_motor", [&] {
          const JointId joint = one_of(joints_);
          world_->set_motor(joint, in_.motor());
        });
        return;
      case 10:
      case 11:
        return add_patch();
      case 12:
        (void)call("remove_patch", [&] { world_->remove_patch(one_of(patches_)); });
        return;
      case 13:
        (void)call("set_parameters", [&] {
          const PatchId patch = one_of(patches_);
          world_->set_parameters(patch, in_.parameters());
        });
        return;
      case 14:
        (void)call("set_active", [&] {
          const PatchId patch = one_of(patches_);
          world_->set_active(patch, in_.once_in(2));
        });
        return;
      case 15:
        (void)call("set_pose", [&] {
          const BodyId id = body();
          world_->set_pose(id, in_.pose(S(1)));
        });
        return;
      case 16:
        (void)call("set_velocity", [&] {
          const BodyId id = body();
          world_->set_velocity(id, in_.twist());
        });
        return;
      case 17:
        (void)call("move_to", [&] {
          const BodyId id = body();
          world_->move_to(id, in_.pose(S(1)));
        });
        return;
      case 18:
        (void)call("apply_wrench", [&] {
          const BodyId id = body();
          const Vec3<S> force = in_.vector(S(20));
          world_->apply_wrench(id, {force, in_.vector(S(2))});
        });
        return;
      case 19:
        (void)call("apply_force", [&] {
          const BodyId id = body();
          const Vec3<S> force = in_.vector(S(20));
          world_->apply_force(id, force, in_.vector(S(1)));
        });
        return;
      case 20:
        (void)call("set_filter", [&] {
          const BodyId id = body();
          world_->set_filter(id, in_.filter());
        });
        return;
      case 21:
        return change_body();
      case 22:
        (void)call("set_time_step", [&] { world_->set_time_step(in_.positive(S(0.02))); });
        return;
      case 23:
        (void)call("set_gravity", [&] { world_->set_gravity(in_.vector(S(10))); });
        return;
      case 24:
        return cast_rays();
      case 25:
        return ask();
      case 26:
        return step_again();
      case 27:
        return restore_damaged();
      case 28:
        return haptic_step();
      default:
        for (std::size_t i = in_.choice(6) + 1; i-- > 0;) step();
    }
  }

  // Arguments of calls

  /// Mostly one that is there.
  template <typename Id>
  Id one_of(const std::vector<Id>& ids) {
    const std::uint8_t which = in_.byte();
    if (ids.empty() || which == 255) return Id{.index = which};
    return ids[which % ids.size()];
  }
  BodyId body() { return one_of(bodies_); }

  JointDef<S> joint_def() {
    JointDef<S> def;
    def.kind = static_cast<JointKind>(in_.choice(6));
    def.body_a = body();
    def.body_b = body();
    // Where the bodies are, for most.
    if (!in_.once_in(8) && world_->contains(def.body_a) && world_->contains(def.body_b)) {
      def.X_AJ = relative_pose(world_->pose(def.body_a), world_->pose(def.body_b));
    } else {
      def.X_AJ = in_.pose(S(0.3));
      def.X_BJ = in_.pose(S(0.3));
    }
    if (in_.once_in(2)) {
      def.lower_limit = in_.number(S(1));
      def.upper_limit = in_.number(S(1));
    }
    if (in_.once_in(4)) def.swing_limit = in_.positive(S(2));
    if (in_.once_in(2)) def.motor = in_.motor();
    if (in_.once_in(4)) {
      const S stiffness = in_.positive(S(500));
      const S damping = in_.positive(S(5));
      def.spring = {stiffness, damping, in_.number(S(1))};
    }
    if (in_.once_in(4)) {
      for (Eigen::Index i = 0; i < 6; ++i) {
        def.bushing.stiffness[i] = in_.positive(S(1000));
        def.bushing.damping[i] = in_.positive(S(10));
      }
    }
    def.bodies_collide = in_.once_in(2);
    return def;
  }

  PatchDef<S> patch_def() {
    PatchDef<S> def = in_.patch_def();
    // Most rays end in bodies of this size. Of the script's bytes it takes none, so that scripts
    // which found something mean what they did.
    def.may_point_inwards = def.sensors.size() != 1;
    if (in_.once_in(8)) def.excluded.push_back(body());
    return def;
  }

  // Kinds of calls

  void add_body() {
    if (bodies_.size() >= most_bodies) return;
    (void)call("add_body", [&] { bodies_.push_back(world_->add_body(in_.body_def())); });
  }
  void remove_body() {
    const BodyId id = body();
    if (call("remove_body", [&] { world_->remove_body(id); })) std::erase(bodies_, id);
  }
  void add_joint() {
    if (joints_.size() >= most_joints) return;
    (void)call("add_joint", [&] { joints_.push_back(world_->add_joint(joint_def())); });
  }
  void add_patch() {
    if (patches_.size() >= most_patches) return;
    (void)call("add_patch", [&] {
      const BodyId id = body();
      patches_.push_back(world_->add_patch(id, patch_def()));
    });
  }

  void cast_rays() {
    (void)call("cast_rays", [&] {
      std::vector<Ray<S>> rays(1 + in_.choice(4));
      for (Ray<S>& ray : rays) {
        ray.origin = in_.vector(S(1));
        ray.direction = in_.direction();
        if (in_.once_in(2)) ray.length = in_.positive(S(3));
      }
      std::vector<WorldHit<S>> hits(rays.size());
      world_->cast_rays(rays, {}, hits);
      for (const WorldHit<S>& hit : hits) {
        demand(hit.distance >= S(0), "a ray hit at a distance of " + std::to_string(hit.distance));
        if (!hit.is_hit()) continue;
        demand(world_->contains(hit.body), "a ray hit a body that is gone");
        demand(is_finite(hit.point), "a ray hit at no point");
        // A ray that starts inside reports its own direction, which is a unit vector to this.
        demand(std::abs(hit.normal.norm() - S(1)) < S(2) * Tolerance<S>::equal(),
               "a ray hit a surface with a normal of length " + std::to_string(hit.normal.norm()));
      }
    });
  }
  /// Makes a call that only queries.
  void ask() {
    (void)call("sense", [&] {
      const BodyId carrier = body();
      ProximityArray<S> array(in_.layout());
      world_->sense(carrier, array);
      for (const S distance : array.distance()) {
        demand(distance >= S(0), "a distance sensor reads " + std::to_string(distance));
      }
    });
    (void)call("largest_stable_step", [&] {
      const S step = world_->largest_stable_step(one_of(patches_));
      demand(step >= S(0), "the largest stable step is " + std::to_string(step));
    });
    (void)call("contact_impulse", [&] {
      const BodyId id = body();
      demand(is_finite(world_->contact_impulse(id, body())), "a contact impulse is not finite");
    });
  }

  void step_again() {
    snapshots_.push_back(world_->snapshot());
    look_at_copies(*world_, snapshots_.back(), 1 + in_.choice(3));
  }
  void restore_damaged() {
    std::vector<std::byte> bytes =
        snapshots_.empty() || in_.once_in(2) ? world_->snapshot() : one_snapshot();
    if (in_.once_in(4)) {
      bytes.resize(bytes.size() * in_.byte() / 256);
    } else {
      for (std::size_t i = 1 + in_.choice(4); i-- > 0 && !bytes.empty();) {
        const std::size_t at = (std::size_t{in_.byte()} * 256 + in_.byte()) * 7919 % bytes.size();
        bytes[at] ^= std::byte{static_cast<std::uint8_t>(1u << in_.choice(8))};
      }
    }
    (void)call("restore", [&] { world_->restore(bytes); });
  }
  const std::vector<std::byte>& one_snapshot() { return snapshots_[in_.choice(snapshots_.size())]; }

  // What a loop shows of itself.
  [[nodiscard]] std::vector<double> seen_of_loop() const {
    std::vector<double> seen;
    const auto add = [&](const Vec3<S>& v) {
      for (const S x : v) seen.push_back(static_cast<double>(x));
    };
    seen.push_back(static_cast<double>(loop_->substep_length()));
    seen.push_back(static_cast<double>(loop_->substeps_done()));
    seen.push_back(static_cast<double>(loop_->rays_cast()));
    for (const ToolId tool : tools_) {
      add(loop_->wrench(tool).force);
      add(loop_->wrench(tool).torque);
    }
    for (const auto& body : loop_->bodies()) {
      add(body.body().twist.linear);
      add(body.body().twist.angular);
    }
    return seen;
  }

  // A call of the loop: one that throws leaves it as it was, as it does the world.
  template <typename Call>
  bool call_of_loop(const char* name, const Call& make) {
    const std::vector<double> before = seen_of_loop();
    const bool is_accepted = call(name, make);
    if (!is_accepted) demand(seen_of_loop() == before, "a call that threw changed a haptic loop");
    return is_accepted;
  }

  void haptic_step() {
    if (!loop_) {
      (void)call("HapticLoop", [&] {
        const auto substeps = static_cast<std::uint32_t>(in_.choice(4));
        loop_.emplace(HapticDef<S>{.substeps = substeps, .max_speed = in_.positive(S(2))});
      });
      if (!loop_) return;
    }
    if (tools_.size() < 2) {
      (void)call("add_tool", [&] { tools_.push_back(loop_->add_tool(body())); });
      (void)call_of_loop("HapticLoop::add_patch",
                         [&] { (void)loop_->add_patch(one_of(tools_), patch_def()); });
    }
    if (!call_of_loop("open", [&] { world_->open(*loop_); })) return;
    for (std::uint32_t i = 0; i < loop_->def().substeps; ++i) {
      for (const ToolId tool : tools_) {
        (void)call_of_loop("move", [&] { loop_->move(tool, in_.pose(S(1))); });
      }
      loop_->substep();
      for (const ToolId tool : tools_) {
        demand(is_finite(loop_->wrench(tool)), "a haptic tool feels what is not finite");
      }
    }
    if (call_of_loop("step with a loop", [&] { world_->step(*loop_); })) look();
  }

  // Steps

  void step() {
    if (counts_.steps >= most_steps) return;
    ++counts_.steps;
    try {
      world_->step();
    } catch (const std::exception& error) {
      throw Finding(std::string("a step threw ") + error.what());
    }
    look();
  }

  void look() {
    drop_dead(patches_);
    drop_dead(joints_);
    look_at_state(*world_, bodies_, patches_, joints_);
    look_at_cost(*world_);
  }
  /// Forgets the handles of what went with its body.
  template <typename Id>
  void drop_dead(std::vector<Id>& ids) {
    std::erase_if(ids, [&](Id id) {
      return !accepts(*world_, "reading", [&] { (void)world_->reading(id); });
    });
  }

  FuzzDefs<S> in_;
  std::optional<World> world_;
  std::optional<Loop> loop_;
  std::vector<BodyId> bodies_;
  std::vector<ShapeId> shapes_;
  std::vector<JointId> joints_;
  std::vector<PatchId> patches_;
  std::vector<ToolId> tools_;
  std::vector<std::vector<std::byte>> snapshots_;
  ScriptCounts counts_;
};

/// Runs bytes as a script; the first byte chooses scalar and backend.
inline ScriptCounts run_world_script(std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) return {};
  const std::uint8_t kind = bytes[0];
  const std::span<const std::uint8_t> script = bytes.subspan(1);
#if defined(BRISTLE_WITH_FCL)
  if ((kind & 2) != 0) {
    return (kind & 1) != 0 ? WorldScript<float, FclBackend>(script).run()
                           : WorldScript<double, FclBackend>(script).run();
  }
#endif
  return (kind & 1) != 0 ? WorldScript<float, AnalyticBackend>(script).run()
                         : WorldScript<double, AnalyticBackend>(script).run();
}

}  // namespace bristle::test
