/// @file
/// How bodies of a world moved, and what pressed on them, kept for a replay.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/geometry/meshes/drawn_mesh.hpp>
#include <bristle/io/recording.hpp>
#include <bristle/io/utf8.hpp>
#include <bristle/math/transform.hpp>
#include <bristle/sensors/patch.hpp>
#include <bristle/sensors/reading.hpp>
#include <bristle/sensors/touch_force.hpp>
#include <bristle/world/world.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// Records bodies, patches, joints and contacts of a world at its own rate, with numbers that the
/// caller names.
///
///     Recorder<double> recorder;                // 60 frames a second
///     recorder.add_body(world, finger, "finger");
///     recorder.add_patch(world, pad, "pad");
///     recorder.add_world(world);                // and all the others
///     for (...) {
///       world.step();
///       recorder.scalar("grip force", "N", world.reading(pad).total_normal());
///       recorder.observe(world);
///     }
///     write_glb("grip.glb", recorder.recording());
///
/// A world without a recorder pays nothing for it. A recorder is for one world, known by its
/// address.
template <Scalar S>
class Recorder {
 public:
  /// @param rate  [1/s] Frames a second, > 0; every step is one where steps are longer.
  explicit Recorder(double rate = 60) : rate_(rate) {
    detail::require_positive("Recorder: rate", rate);
  }

  /// Records a body from the next frame on, and the contacts that press on it.
  ///
  /// @param def         What it looks like: what it was added to the world by, or other shapes.
  /// @param plane_size  [m] Side of the square that a half-space is drawn as, > 0.
  /// @throws InvalidArgument when the body is recorded already, a shape is none, or the name is not
  ///         UTF-8.
  void add_body(BodyId id, const BodyDef<S>& def, std::string name, S plane_size = S(2));
  /// The same; it looks like the shapes that it has now.
  /// @throws InvalidArgument for an unknown body, too, and for another world's.
  template <typename Backend>
  requires detail::TellsShapes<Backend, S>
  void add_body(const World<S, Backend>& world, BodyId id, std::string name, S plane_size = S(2));
  /// Records the sensors of a patch from the next frame on.
  /// @throws InvalidArgument when the patch is unknown, recorded already or another world's, its
  ///         body is not recorded, or the name is not UTF-8.
  template <typename Backend>
  void add_patch(const World<S, Backend>& world, PatchId id, std::string name);
  /// Records a joint from the next frame on: position and force of its motor, where it has an axis.
  /// @throws InvalidArgument when the joint is unknown, recorded already or another world's, its
  ///         body B is not recorded, or the name is not UTF-8.
  template <typename Backend>
  void add_joint(const World<S, Backend>& world, JointId id, std::string name);
  /// Records all that is in a world now and not recorded yet, as "body 3", "patch 0", "joint 7".
  template <typename Backend>
  requires detail::TellsShapes<Backend, S>
  void add_world(const World<S, Backend>& world, S plane_size = S(2));

  /// Sets a number that the next frames have, until it is set again. A name is known from its first
  /// call on.
  /// @param unit  As plots show it; empty for a pure number.
  /// @throws InvalidArgument when the value is not finite in float, name or unit are not UTF-8, or
  ///         the unit is another than before.
  void scalar(std::string_view name, std::string_view unit, double value);

  /// To be called after each step of the world that is recorded: takes a frame when it is time for
  /// one. A bristle that lets go slips for one step, so a frame has as slipping what touches and
  /// slipped in any step since the frame before.
  /// @throws InvalidArgument for another world than before, a copy too, and when a patch has other
  ///         sensors, since another world was assigned to this one. Nothing is recorded then.
  template <typename Backend>
  void observe(const World<S, Backend>& world);

  /// Goes on with the same world at another address, after it was moved or copied.
  template <typename Backend>
  void follow(const World<S, Backend>& world) {
    world_ = &world;
  }

  /// All frames so far. Valid as long as the recorder.
  [[nodiscard]] const Recording<S>& recording() const noexcept { return recording_; }

 private:
  using Body = typename Recording<S>::Body;
  using Patch = typename Recording<S>::Patch;
  using Contact = typename Recording<S>::Contact;
  using Joint = typename Recording<S>::Joint;
  using Channel = typename Recording<S>::Channel;

  template <typename Backend>
  void require_own(const World<S, Backend>& world) {
    if (world_ == nullptr) follow(world);
    detail::require(world_ == &world, "Recorder: world", "another",
                    "must be the world it was added from; `follow` one that was moved");
  }
  /// Number of what was added under an id; as many as there are where it was not.
  template <typename Id>
  [[nodiscard]] static std::size_t number_of(const std::vector<Id>& ids, Id id) {
    return static_cast<std::size_t>(std::find(ids.begin(), ids.end(), id) - ids.begin());
  }
  template <typename Id>
  static void require_new(const std::vector<Id>& ids, Id id, const char* field) {
    detail::require(number_of(ids, id) == ids.size(), field, id.index,
                    "must not be recorded already");
  }
  [[nodiscard]] bool is_recorded(BodyId id) const {
    return id.index < numbers_.size() && numbers_[id.index] < bodies_.size() &&
           bodies_[numbers_[id.index]] == id;
  }
  static void add_shape(const Shape<S>& shape, const Transform<S>& X_BS, S plane_size,
                        TriangleMesh<S>& mesh);
  void insert_body(BodyId id, Body body);
  template <typename Backend>
  void note_slips(const World<S, Backend>& world);
  template <typename Backend>
  void observe_patch(const World<S, Backend>& world, std::size_t number);
  template <typename Backend>
  [[nodiscard]] std::vector<Contact> contacts_of(const World<S, Backend>& world, double dt) const;

  double rate_;
  /// [s] Of the last step, and of the next frame.
  double time_ = 0;
  double due_ = 0;
  Recording<S> recording_;
  std::vector<BodyId> bodies_;    // Of the recording's bodies,
  std::vector<PatchId> patches_;  // of its patches,
  std::vector<JointId> joints_;   // and of its joints.
  /// Numbers of the recorded bodies by their slots.
  std::vector<std::size_t> numbers_;
  /// Patch by patch, sensor by sensor: whether it slipped since the last frame.
  std::vector<std::vector<bool>> slipped_;
  /// Of the recording's channels, for the next frame.
  std::vector<double> values_;
  /// The world that is recorded, to know it again.
  const void* world_ = nullptr;
};

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
void Recorder<S>::add_shape(const Shape<S>& shape, const Transform<S>& X_BS, S plane_size,
                            TriangleMesh<S>& mesh) {
  const TriangleMesh<S> drawn = drawn_mesh<S>(shape, plane_size);
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const Vec3<S>& v : drawn.vertices) mesh.vertices.push_back(X_BS * v);
  for (const auto& t : drawn.triangles) {
    mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  }
}

template <Scalar S>
void Recorder<S>::insert_body(BodyId id, Body body) {
  detail::require_utf8("Recorder: name", body.name);
  body.poses.resize(recording_.times.size());
  body.was_there.resize(recording_.times.size(), false);
  if (numbers_.size() <= id.index) {
    numbers_.resize(id.index + std::size_t{1}, static_cast<std::size_t>(-1));
  }
  numbers_[id.index] = bodies_.size();
  recording_.bodies.push_back(std::move(body));
  bodies_.push_back(id);
}

template <Scalar S>
void Recorder<S>::add_body(BodyId id, const BodyDef<S>& def, std::string name, S plane_size) {
  detail::require(id != BodyId{}, "Recorder: BodyId", id, "must name a body");
  require_new(bodies_, id, "Recorder: BodyId");
  for (const ShapeDef<S>& s : def.shapes) validate(s);
  Body body;
  body.name = std::move(name);
  body.moves = def.motion != Motion::fixed;
  if (def.shape) add_shape(*def.shape, {}, plane_size, body.mesh);
  for (const ShapeDef<S>& s : def.shapes) {
    if (!s.is_trigger) add_shape(s.shape, s.X_BS, plane_size, body.mesh);
  }
  insert_body(id, std::move(body));
}

template <Scalar S>
template <typename Backend>
requires detail::TellsShapes<Backend, S>
void Recorder<S>::add_body(const World<S, Backend>& world, BodyId id, std::string name,
                           S plane_size) {
  require_own(world);
  require_new(bodies_, id, "Recorder: BodyId");
  Body body;
  body.name = std::move(name);
  body.moves = world.body(id).motion != Motion::fixed;
  world.for_each_shape(id, [&](ShapeId, const ShapeDef<S>& shape) {
    if (!shape.is_trigger) add_shape(shape.shape, shape.X_BS, plane_size, body.mesh);
  });
  insert_body(id, std::move(body));
}

template <Scalar S>
template <typename Backend>
void Recorder<S>::add_patch(const World<S, Backend>& world, PatchId id, std::string name) {
  require_own(world);
  const detail::SensorPatch<S>& sensors = world.patch(id);
  require_new(patches_, id, "Recorder: PatchId");
  detail::require(is_recorded(sensors.body), "Recorder: PatchId", id.index,
                  "must be on a body that is recorded");
  detail::require_utf8("Recorder: name", name);
  Patch patch;
  patch.name = std::move(name);
  patch.body = numbers_[sensors.body.index];
  const Vec3<S>& center = world.body(sensors.body).center_B;
  const detail::PatchGeometry<S>& rays = *sensors.geometry;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    patch.ends.push_back(center + rays.start[i] + rays.length[i] * rays.direction[i]);
    patch.directions.push_back(rays.direction[i]);
  }
  const std::size_t past = recording_.times.size() * patch.ends.size();
  patch.forces.resize(past, detail::zero<Vec3<S>>());
  patch.depths.resize(past);
  patch.states.resize(past, SensorState::free);
  recording_.patches.push_back(std::move(patch));
  slipped_.emplace_back(sensors.size(), false);
  patches_.push_back(id);
}

template <Scalar S>
template <typename Backend>
void Recorder<S>::add_joint(const World<S, Backend>& world, JointId id, std::string name) {
  require_own(world);
  const JointDef<S>& def = world.joint(id).def;
  require_new(joints_, id, "Recorder: JointId");
  detail::require(is_recorded(def.body_b), "Recorder: JointId", id.index,
                  "must have a body B that is recorded");
  detail::require_utf8("Recorder: name", name);
  Joint joint;
  joint.name = std::move(name);
  joint.body = numbers_[def.body_b.index];
  joint.X_BJ = def.X_BJ;
  joint.turns = def.kind == JointKind::revolute || def.kind == JointKind::cone_twist;
  joint.slides = def.kind == JointKind::prismatic;
  joint.positions.resize(recording_.times.size());
  joint.motor_forces.resize(recording_.times.size());
  recording_.joints.push_back(std::move(joint));
  joints_.push_back(id);
}

template <Scalar S>
template <typename Backend>
requires detail::TellsShapes<Backend, S>
void Recorder<S>::add_world(const World<S, Backend>& world, S plane_size) {
  require_own(world);
  world.for_each_body([&](BodyId id) {
    if (is_recorded(id)) return;
    add_body(world, id, "body " + std::to_string(id.index), plane_size);
  });
  world.for_each_patch([&](PatchId id) {
    if (number_of(patches_, id) < patches_.size()) return;
    add_patch(world, id, "patch " + std::to_string(id.index));
  });
  world.for_each_joint([&](JointId id) {
    if (number_of(joints_, id) < joints_.size()) return;
    add_joint(world, id, "joint " + std::to_string(id.index));
  });
}

template <Scalar S>
void Recorder<S>::scalar(std::string_view name, std::string_view unit, double value) {
  detail::require_finite("Recorder: scalar", static_cast<float>(value));
  const auto known = std::find_if(recording_.channels.begin(), recording_.channels.end(),
                                  [name](const Channel& channel) { return channel.name == name; });
  if (known != recording_.channels.end()) {
    detail::require(known->unit == unit, "Recorder: unit", std::string(unit).c_str(),
                    "must be that of the scalar's first call");
    values_[static_cast<std::size_t>(known - recording_.channels.begin())] = value;
    return;
  }
  detail::require_utf8("Recorder: name", name);
  detail::require_utf8("Recorder: unit", unit);
  recording_.channels.push_back(
      {std::string(name), std::string(unit), recording_.times.size(), {}});
  values_.push_back(value);
}

template <Scalar S>
template <typename Backend>
void Recorder<S>::note_slips(const World<S, Backend>& world) {
  for (std::size_t k = 0; k < patches_.size(); ++k) {
    if (!world.contains(patches_[k])) continue;
    const PatchReading<S> reading = world.reading(patches_[k]);
    detail::require(reading.size() == slipped_[k].size(), "Recorder: PatchId", patches_[k].index,
                    "must have as many sensors as when it was added");
    if (reading.slipping() == 0) continue;
    for (std::size_t i = 0; i < reading.size(); ++i) {
      if (reading.state[i] == SensorState::slipping) slipped_[k][i] = true;
    }
  }
}

template <Scalar S>
template <typename Backend>
void Recorder<S>::observe_patch(const World<S, Backend>& world, std::size_t number) {
  Patch& patch = recording_.patches[number];
  if (!world.contains(patches_[number])) {
    const std::size_t count = recording_.times.size() * patch.ends.size();
    patch.forces.resize(count, detail::zero<Vec3<S>>());
    patch.depths.resize(count);
    patch.states.resize(count, SensorState::free);
    return;
  }
  const PatchReading<S> reading = world.reading(patches_[number]);
  for (std::size_t i = 0; i < patch.ends.size(); ++i) {
    const bool has_slipped = reading.state[i] != SensorState::free && slipped_[number][i];
    patch.forces.push_back(touch_force(reading, i, patch.directions[i]));
    patch.depths.push_back(static_cast<float>(reading.depth[i]));
    patch.states.push_back(has_slipped ? SensorState::slipping : reading.state[i]);
  }
  slipped_[number].assign(patch.ends.size(), false);
}

/// Points of the last step that exchanged an impulse. Each names a recorded body and the force on
/// it [N]: the impulse over `dt` [s].
template <Scalar S>
template <typename Backend>
auto Recorder<S>::contacts_of(const World<S, Backend>& world, double dt) const
    -> std::vector<Contact> {
  std::vector<Contact> contacts;
  world.for_each_contact([&](const ContactReading<S>& pair) {
    const bool has_a = is_recorded(pair.body_a);
    const bool has_b = is_recorded(pair.body_b);
    if (!has_a && !has_b) return;
    // The force is that on the body that moves, b where both do.
    const bool is_on_b = has_b && (!has_a || recording_.bodies[numbers_[pair.body_b.index]].moves ||
                                   !recording_.bodies[numbers_[pair.body_a.index]].moves);
    const std::size_t body = numbers_[is_on_b ? pair.body_b.index : pair.body_a.index];
    pair.for_each_point([&](const typename ContactReading<S>::Point& point) {
      const Vec3<S> impulse = point.normal_impulse * point.normal + point.friction_impulse;
      if (impulse.isZero(S(0))) return;
      const Vec3<S> force = impulse / S(dt);
      contacts.push_back({body, point.position, is_on_b ? force : Vec3<S>(-force)});
    });
  });
  return contacts;
}

template <Scalar S>
template <typename Backend>
void Recorder<S>::observe(const World<S, Backend>& world) {
  require_own(world);
  note_slips(world);
  const double dt = static_cast<double>(world.time_step());
  time_ += dt;
  std::vector<double>& times = recording_.times;
  // The step that ends next to the frame's instant; instants that long steps missed are left out.
  if (!times.empty() && time_ + dt / 2 < due_) return;
  due_ = (times.empty() || due_ + 1 / rate_ < time_ ? time_ : due_) + 1 / rate_;
  times.push_back(time_);
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    Body& body = recording_.bodies[k];
    const bool is_there = world.contains(bodies_[k]);
    body.was_there.push_back(is_there);
    // Where it was last, for what looks at two frames at once.
    const Transform<S> last = body.poses.empty() ? Transform<S>{} : body.poses.back();
    body.poses.push_back(is_there ? world.pose(bodies_[k]) : last);
  }
  for (std::size_t k = 0; k < patches_.size(); ++k) observe_patch(world, k);
  recording_.contacts.push_back(contacts_of(world, dt));
  for (std::size_t k = 0; k < joints_.size(); ++k) {
    Joint& joint = recording_.joints[k];
    const bool is_there = world.contains(joints_[k]);
    const JointReading<S> reading = is_there ? world.reading(joints_[k]) : JointReading<S>{};
    const S last = joint.positions.empty() ? S(0) : joint.positions.back();
    joint.positions.push_back(is_there ? reading.position : last);
    joint.motor_forces.push_back(reading.motor_force);
  }
  for (std::size_t k = 0; k < values_.size(); ++k) {
    recording_.channels[k].values.push_back(values_[k]);
  }
}

}  // namespace bristle::inline BRISTLE_ABI
