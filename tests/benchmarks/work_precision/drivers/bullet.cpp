// Bullet, in the precision it was built for.
// SPDX-License-Identifier: BSD-3-Clause
#include "benchmarks/work_precision/drivers/features.hpp"
#include "benchmarks/work_precision/drivers/slab.hpp"
#include "benchmarks/work_precision/engines.hpp"

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletDynamicsCommon.h>
#include <cmath>

// A global of Bullet that has no header.
extern btScalar gContactBreakingThreshold;

namespace bristle::work_precision {

using namespace bristle::detail;

namespace {

using scenes::Scene;
using scenes::SceneBody;
using scenes::Vector;

btVector3 to_bullet(const Vector& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}
btQuaternion to_bullet(const scenes::Rotation& q) {
  return {static_cast<btScalar>(q.x()), static_cast<btScalar>(q.y()), static_cast<btScalar>(q.z()),
          static_cast<btScalar>(q.w())};
}
Vector from_bullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

/// Settings: `def` 10 iterations; `it50` 50 of them; `2dir` two directions of friction; `anchor`
/// those and friction anchors; `erp0` no position correction and a contact margin of 10 um, which
/// is how SimBenchmark runs it; `gimp` meshes as triangles, not as hulls.
class BulletEngine : public scenes::Engine {
 public:
  BulletEngine(const Scene& scene, double dt, const std::string& setting)
      : dispatcher_(&configuration_),
        world_(&dispatcher_, &broadphase_, &solver_, &configuration_),
        dt_(static_cast<btScalar>(dt)),
        setting_(setting) {
    configure();
    world_.setGravity(to_bullet(scene.gravity));
    for (const SceneBody& body : scene.bodies) add(scene, body);
    for (const scenes::SceneJoint& joint : scene.joints) add(joint);
  }

  void step() override { world_.stepSimulation(dt_, 0); }

  [[nodiscard]] scenes::BodyState state(std::size_t i) const override {
    const btRigidBody& body = *bodies_[i];
    const btQuaternion q = body.getWorldTransform().getRotation();
    return {from_bullet(body.getWorldTransform().getOrigin()),
            scenes::Rotation(q.w(), q.x(), q.y(), q.z()), from_bullet(body.getLinearVelocity()),
            from_bullet(body.getAngularVelocity())};
  }
  void push(std::size_t i, const Vector& force) override {
    bodies_[i]->applyCentralForce(to_bullet(force));
  }
  [[nodiscard]] scenes::StepCounters counters() const override {
    return {static_cast<std::uint64_t>(iterations_), 0};
  }

 private:
  void configure() {
    btContactSolverInfo& info = world_.getSolverInfo();
    if (setting_ == "it50") iterations_ = 50;
    info.m_numIterations = iterations_;
    info.m_restitutionVelocityThreshold = btScalar(0.01);
    if (setting_ == "2dir" || setting_ == "anchor") {
      info.m_solverMode |= SOLVER_USE_2_FRICTION_DIRECTIONS;
    }
    if (setting_ == "anchor") info.m_frictionERP = btScalar(0.2);
    if (setting_ == "erp0") {
      info.m_erp = info.m_erp2 = 0;
      gContactBreakingThreshold = btScalar(1e-5);
    }
  }

  template <typename T, typename... Arguments>
  T* keep(Arguments&&... arguments) {
    auto shape = std::make_unique<T>(std::forward<Arguments>(arguments)...);
    T* raw = shape.get();
    shapes_.push_back(std::move(shape));
    return raw;
  }

  btCollisionShape* mesh_shape(const TriangleMesh<double>& mesh) {
    // The default margin of 40 mm would inflate the shape by as much.
    constexpr auto margin = static_cast<btScalar>(0.001);
    if (setting_ == "gimp") {
      meshes_.push_back(std::make_unique<btTriangleMesh>());
      for (const auto& t : mesh.triangles) {
        meshes_.back()->addTriangle(to_bullet(mesh.vertices[t[0]]), to_bullet(mesh.vertices[t[1]]),
                                    to_bullet(mesh.vertices[t[2]]));
      }
      btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher_);
      auto* shape = keep<btGImpactMeshShape>(meshes_.back().get());
      shape->setMargin(margin);
      shape->updateBound();
      return shape;
    }
    auto* shape = keep<btConvexHullShape>();
    for (const Vector& v : mesh.vertices) shape->addPoint(to_bullet(v), false);
    shape->recalcLocalAabb();
    shape->setMargin(margin);
    return shape;
  }

  btCollisionShape* shape_of(const Scene& scene, const SceneBody& body, btTransform& pose) {
    if (const auto* ball = std::get_if<Sphere<double>>(&body.shape)) {
      return keep<btSphereShape>(static_cast<btScalar>(ball->radius));
    }
    if (const auto* box = std::get_if<Box<double>>(&body.shape)) {
      return keep<btBoxShape>(to_bullet(box->half_extents));
    }
    if (const auto* disk = std::get_if<Cylinder<double>>(&body.shape)) {
      return keep<btCylinderShapeZ>(to_bullet({disk->radius, disk->radius, disk->half_length}));
    }
    if (const auto* ground = std::get_if<HalfSpace<double>>(&body.shape)) {
      if (!has_shape<Box<double>>(scene)) {
        return keep<btStaticPlaneShape>(to_bullet(ground->normal),
                                        static_cast<btScalar>(ground->offset));
      }
      const Slab slab = slab_of(*ground);
      pose = btTransform(to_bullet(slab.orientation), to_bullet(slab.position));
      return keep<btBoxShape>(to_bullet(slab.half));
    }
    return mesh_shape(std::get<TriangleMesh<double>>(body.shape));
  }

  void add(const Scene& scene, const SceneBody& body) {
    btTransform pose(to_bullet(body.orientation), to_bullet(body.position));
    btCollisionShape* shape = shape_of(scene, body, pose);
    const btVector3 inertia =
        body.moves() ? to_bullet(scenes::principal_inertia(body)) : btVector3(0, 0, 0);
    states_.push_back(std::make_unique<btDefaultMotionState>(pose));
    btRigidBody::btRigidBodyConstructionInfo info(static_cast<btScalar>(body.mass),
                                                  states_.back().get(), shape, inertia);
    info.m_friction = static_cast<btScalar>(body.friction);
    info.m_restitution = static_cast<btScalar>(std::sqrt(scene.restitution));
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    btRigidBody& added = *bodies_.back();
    added.setActivationState(DISABLE_DEACTIVATION);
    if (setting_ == "anchor") {
      added.setCollisionFlags(added.getCollisionFlags() |
                              btCollisionObject::CF_HAS_FRICTION_ANCHOR);
    }
    added.setLinearVelocity(to_bullet(body.velocity));
    added.setAngularVelocity(to_bullet(body.angular_velocity));
    if (body.slides_along_x) {
      added.setLinearFactor(btVector3(1, 0, 0));
      added.setAngularFactor(btVector3(0, 0, 0));
    }
    constexpr int fixed = 1;
    constexpr int moving = 2;
    const int mask = body.meets == scenes::Meets::everything     ? fixed | moving
                     : body.meets == scenes::Meets::fixed_bodies ? fixed
                                                                 : 0;
    world_.addRigidBody(&added, body.moves() ? moving : fixed, mask);
  }

  void add(const scenes::SceneJoint& joint) {
    const btVector3 anchor = to_bullet(joint.anchor);
    btRigidBody& b = *bodies_[static_cast<std::size_t>(joint.b)];
    const btVector3 in_b = b.getWorldTransform().inverse() * anchor;
    if (joint.a < 0) {
      joints_.push_back(std::make_unique<btPoint2PointConstraint>(b, in_b));
    } else {
      btRigidBody& a = *bodies_[static_cast<std::size_t>(joint.a)];
      joints_.push_back(std::make_unique<btPoint2PointConstraint>(
          a, b, a.getWorldTransform().inverse() * anchor, in_b));
    }
    world_.addConstraint(joints_.back().get(), true);
  }

  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  std::vector<std::unique_ptr<btTriangleMesh>> meshes_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btMotionState>> states_;
  // The world lets go of what is in it before those go.
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<std::unique_ptr<btTypedConstraint>> joints_;
  btDiscreteDynamicsWorld world_;
  btScalar dt_;
  std::string setting_;
  int iterations_ = 10;
};

}  // namespace

std::vector<EngineFamily> engine_families() {
#ifdef BT_USE_DOUBLE_PRECISION
  const char* name = "bullet64";
#else
  const char* name = "bullet32";
#endif
  return {{name,
           {"def", "it50", "2dir", "anchor", "erp0", "gimp"},
           [](const Scene& scene, double dt,
              const std::string& setting) -> std::unique_ptr<scenes::Engine> {
             if (setting == "gimp" && !has_shape<TriangleMesh<double>>(scene)) {
               throw scenes::Unsupported("gimp differs from def in scenes with meshes only");
             }
             require_known(scene, {.has_cylinders = true});
             return std::make_unique<BulletEngine>(scene, dt, setting);
           }}};
}

}  // namespace bristle::work_precision
