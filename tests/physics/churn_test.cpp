/// @file
/// Things that come and go between steps at any time: nothing is left over and nothing dangles.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"
#include "support/rounds.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

using namespace bristle;
using namespace bristle::detail;

namespace {

/// A world to which a seeded sequence of operations happens.
class Churn {
 public:
  Churn(std::uint64_t seed, bool sleeps) : random_(seed), world_(def_of(sleeps)) {
    BodyDef<double> floor;
    floor.motion = Motion::fixed;
    floor.shape = HalfSpace<double>{};
    world_.add_body(floor);
  }

  /// One operation, or a few steps.
  void act() {
    switch (random_.index(16)) {
      case 0:
      case 1:
        return add_body();
      case 2:
        return drop(bodies_, [&](BodyId id) { world_.remove_body(id); });
      case 3:
        return add_shape();
      case 4:
        return drop(shapes_, [&](ShapeId id) { world_.remove_shape(id); });
      case 5:
      case 6:
        return add_joint();
      case 7:
        return drop(joints_, [&](JointId id) { world_.remove_joint(id); });
      case 8:
      case 9:
        return add_patch();
      case 10:
        return drop(patches_, [&](PatchId id) { world_.remove_patch(id); });
      case 11:
        return nudge();
      default:
        for (std::size_t i = 0; i < 1 + random_.index(6); ++i) step();
    }
  }

  void step() {
    world_.step();
    const StepReport<double>& r = world_.report();
    most_asleep_ = std::max(most_asleep_, r.sleeping_bodies);
    sensed_ += r.sensors_touching;
    CHECK(r.backend_failures == 0);
    std::size_t dynamic = 0;
    for (const BodyId id : bodies_) {
      if (!world_.contains(id)) continue;
      const Body<double>& body = world_.body(id);
      if (body.is_dynamic()) ++dynamic;
      REQUIRE(body.center_pose.translation.allFinite());
      REQUIRE(body.center_pose.rotation.coeffs().allFinite());
      REQUIRE(body.twist.linear.allFinite());
      REQUIRE(body.twist.angular.allFinite());
    }
    CHECK(r.sleeping_bodies + r.awake_bodies == dynamic);
    // All that events and contacts name exists, but for what has ended.
    world_.for_each_contact_event([&](const ContactEvent& e) {
      if (e.phase == ContactEvent::Phase::end) return;
      CHECK(world_.contains(e.body_a));
      CHECK(world_.contains(e.body_b));
    });
    world_.for_each_contact([&](const ContactReading<double>& contact) {
      CHECK(contact.impulse_on_b().force.allFinite());
      CHECK(world_.contains(contact.body_a));
    });
  }

  /// Removes everything but the floor.
  void clear() {
    for (const BodyId id : bodies_) {
      if (world_.contains(id)) world_.remove_body(id);
    }
  }

  [[nodiscard]] const World<double>& world() const { return world_; }
  [[nodiscard]] std::uint64_t most_asleep() const { return most_asleep_; }
  [[nodiscard]] std::uint64_t sensed() const { return sensed_; }

 private:
  static WorldDef<double> def_of(bool sleeps) {
    WorldDef<double> def;
    if (sleeps) def.sleep = {0.05, 0.3, 0.05};
    return def;
  }

  /// A body that exists, or none.
  BodyId any_body() {
    if (bodies_.empty()) return {};
    const BodyId id = bodies_[random_.index(bodies_.size())];
    return world_.contains(id) ? id : BodyId{};
  }

  void add_body() {
    if (world_.body_count() > 25) return;
    BodyDef<double> def;
    const std::size_t kind = random_.index(8);
    def.motion = kind == 0 ? Motion::fixed : kind == 1 ? Motion::kinematic : Motion::dynamic;
    def.mass = random_.uniform(0.1, 2.0);
    const Vec3<double> half = Vec3<double>::Constant(0.05) + 0.05 * random_.in_cube(0.5).cwiseAbs();
    def.shape = random_.index(2) == 0 ? OptionalShape<double>(Sphere<double>{half.x()})
                                      : OptionalShape<double>(Box<double>{half});
    if (random_.index(3) == 0) {
      ShapeDef<double> second;
      second.shape = Sphere<double>{0.04};
      second.X_BS.translation = {0.06, 0, 0};
      def.shapes.push_back(second);
    }
    def.position = random_.in_cube(0.3) + Vec3<double>(0, 0, 0.45);
    def.velocity = random_.in_cube(0.5);
    if (def.motion == Motion::kinematic && random_.index(2) == 0) def.velocity.setZero();
    bodies_.push_back(world_.add_body(def));
  }

  void add_shape() {
    const BodyId id = any_body();
    if (id == BodyId{}) return;
    ShapeDef<double> def;
    def.shape = Box<double>{{0.03, 0.03, 0.03}};
    def.X_BS = random_.pose<double>(0.06);
    shapes_.push_back(world_.add_shape(id, def));
  }

  void add_joint() {
    JointDef<double> def;
    def.body_a = any_body();
    def.body_b = any_body();
    if (def.body_a == BodyId{} || def.body_b == BodyId{} || def.body_a == def.body_b) return;
    if (!world_.body(def.body_a).is_dynamic() && !world_.body(def.body_b).is_dynamic()) return;
    // As they stand now, so that nothing is torn.
    def.X_AJ = relative_pose(world_.pose(def.body_a), world_.pose(def.body_b));
    def.kind = random_.index(2) == 0 ? JointKind::fixed : JointKind::prismatic;
    if (def.kind == JointKind::prismatic) {
      def.lower_limit = -0.05;
      def.upper_limit = 0.05;
      def.motor = {MotorMode::velocity, random_.uniform(-0.1, 0.1), 5, 1};
    }
    joints_.push_back(world_.add_joint(def));
  }

  void add_patch() {
    const BodyId id = any_body();
    if (id == BodyId{}) return;
    PatchDef<double> def{.may_point_inwards = true};
    for (int i = 0; i < 4; ++i) {
      def.sensors.add(0.04 * random_.direction<double>(), random_.direction<double>(), 0.06);
    }
    def.parameters = {2, 0.02, 2000, 0.2, 1e-3};
    def.integration = random_.index(2) == 0 ? Integration::implicit : Integration::automatic;
    patches_.push_back(world_.add_patch(id, def));
  }

  void nudge() {
    const BodyId id = any_body();
    if (id == BodyId{}) return;
    const Body<double>& body = world_.body(id);
    switch (random_.index(5)) {
      case 0:
        return world_.apply_force(id, random_.in_cube(3.0), body.center_pose.translation);
      case 1:
        if (body.motion != Motion::fixed)
          world_.set_velocity(id, {random_.in_cube(0.3), {0, 0, 0}});
        return;
      case 2:
        return world_.set_filter(id, {1, random_.index(4) == 0 ? 0u : 1u, 0});
      case 3:
        return world_.wake(id);
      default:
        return world_.set_pose(
            id, {Quat<double>::Identity(), random_.in_cube(0.3) + Vec3<double>(0, 0, 0.45)});
    }
  }

  template <typename Id, typename Remove>
  void drop(std::vector<Id>& ids, Remove&& remove) {
    if (ids.empty()) return;
    const std::size_t k = random_.index(ids.size());
    const Id id = ids[k];
    ids.erase(ids.begin() + static_cast<std::ptrdiff_t>(k));
    // It may have gone with its body; then the world says so, and nothing else happens.
    const std::uint64_t before = world_.state_hash();
    try {
      remove(id);
    } catch (const InvalidArgument&) {
      CHECK(world_.state_hash() == before);
    }
  }

  test::Random random_;
  World<double> world_;
  std::vector<BodyId> bodies_;
  std::vector<ShapeId> shapes_;
  std::vector<JointId> joints_;
  std::vector<PatchId> patches_;
  std::uint64_t most_asleep_ = 0;
  std::uint64_t sensed_ = 0;
};

}  // namespace

TEST_CASE("churn: a thousand operations between steps, twice with the same bits") {
  for (const bool sleeps : {false, true}) {
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
      INFO("seed ", seed, sleeps ? ", with sleep" : "");
      Churn first(seed, sleeps);
      Churn second(seed, sleeps);
      const int operations = test::rounds(1000);
      for (int i = 0; i < operations; ++i) {
        first.act();
        second.act();
        REQUIRE(first.world().state_hash() == second.world().state_hash());
      }
      CHECK((first.most_asleep() > 0) == sleeps);
      CHECK(first.sensed() > 0);

      // An empty world is as good as new: it tests, senses and solves nothing for removed bodies.
      first.clear();
      first.step();
      const StepReport<double>& r = first.world().report();
      CHECK(first.world().body_count() == 1);
      CHECK(r.patches == 0);
      CHECK(r.pairs_tested == 0);
      CHECK(r.rows == 0);
      CHECK(r.sleeping_bodies == 0);
      CHECK(first.world().contacts().manifolds().empty());
      const Ray<double> ray{{0.1, 0.1, 3}, {0, 0, -1}, 2.9};
      CHECK_FALSE(first.world().cast_ray(ray).is_hit());
    }
  }
}

TEST_CASE("churn: slots are used again, so a world does not grow by what has left it") {
  World<double> world;
  BodyDef<double> def;
  def.shape = Sphere<double>{0.1};
  std::uint32_t highest = 0;
  for (int i = 0; i < 200; ++i) {
    const BodyId a = world.add_body(def);
    def.position.x() = 1;
    const BodyId b = world.add_body(def);
    const ShapeId shape = world.add_shape(a, {.shape = Sphere<double>{0.05}});
    const JointId joint = world.add_joint({.body_a = a, .body_b = b});
    PatchDef<double> patch;
    patch.sensors.add({0, 0, 0}, {0, 0, 1}, 0.2);
    const PatchId skin = world.add_patch(b, patch);
    world.step();
    highest = std::max({highest, a.index, b.index, shape.index, joint.index, skin.index});
    world.remove_body(a);
    world.remove_body(b);
  }
  CHECK(highest == 2);
  CHECK(world.body_count() == 0);
  CHECK(world.snapshot().size() < 500);
}
