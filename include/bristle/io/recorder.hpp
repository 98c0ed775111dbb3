/// @file
/// How bodies of a world moved, and what their sensors gave, kept for a replay.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/geometry/meshes/drawn_mesh.hpp>
#include <bristle/math/rotation.hpp>
#include <bristle/math/transform.hpp>
#include <bristle/sensors/patch.hpp>
#include <bristle/sensors/reading.hpp>
#include <bristle/world/world.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// What a replay shows. Frames are instants; all vectors of a body or patch that run over frames
/// are as long as `times`.
template <Scalar S>
struct Recording {
  struct Body {
    std::string name;
    /// Whether the world moves it.
    bool moves = false;
    /// [m] What it looks like, in its frame.
    TriangleMesh<S> mesh;
    /// [m] Frame by frame: its pose in the world, and whether it was there.
    std::vector<Transform<S>> poses;
    std::vector<bool> was_there;
  };
  struct Patch {
    std::string name;
    /// [-] Number of the body that carries it.
    std::size_t body = 0;
    /// [m] Ends of the sensors' rays, in the body's frame.
    std::vector<Vec3<S>> ends;
    /// [N] Frame by frame, sensor by sensor: the force on what the sensor touches, in the body's
    /// frame.
    std::vector<Vec3<S>> forces;
  };

  /// [s] Of the frames, since the recorder's first step; ascending.
  std::vector<double> times;
  std::vector<Body> bodies;
  std::vector<Patch> patches;
};

/// Records chosen bodies and patches of a world at its own rate.
///
///     Recorder<double> recorder;                // 60 frames a second
///     recorder.add_body(finger, finger_def, "finger");
///     recorder.add_patch(world, pad, "pad");
///     for (...) { world.step(); recorder.observe(world); }
///     write_glb("grip.glb", recorder.recording());
///
/// A world without a recorder pays nothing for it.
template <Scalar S>
class Recorder {
 public:
  /// @param rate  [1/s] Frames a second, > 0; every step is one where steps are longer.
  explicit Recorder(double rate = 60) : rate_(rate) {
    detail::require_positive("Recorder: rate", rate);
  }

  /// Records a body from the next frame on.
  ///
  /// @param def         What it was added to the world by: its shapes are what it looks like.
  /// @param plane_size  [m] Side of the square that a half-space is drawn as, > 0.
  /// @throws InvalidArgument when the body is recorded already, or a shape is none.
  void add_body(BodyId id, const BodyDef<S>& def, std::string name, S plane_size = S(2));
  /// Records the sensors of a patch from the next frame on.
  /// @throws InvalidArgument when the patch is unknown or recorded already, or its body is not
  ///         recorded.
  template <typename Backend>
  void add_patch(const World<S, Backend>& world, PatchId id, std::string name);

  /// To be called after each step of the world that bodies and patches were added from: takes a
  /// frame when it is time for one.
  /// @throws InvalidArgument when a patch has other sensors than when it was added, so that it is
  ///         another world's.
  template <typename Backend>
  void observe(const World<S, Backend>& world);

  [[nodiscard]] const Recording<S>& recording() const noexcept { return recording_; }

 private:
  [[nodiscard]] std::size_t number_of(BodyId id) const {
    return static_cast<std::size_t>(std::find(bodies_.begin(), bodies_.end(), id) -
                                    bodies_.begin());
  }

  double rate_;
  /// [s] Of the last step, and of the next frame.
  double time_ = 0;
  double due_ = 0;
  Recording<S> recording_;
  std::vector<BodyId> bodies_;    // Of the recording's bodies,
  std::vector<PatchId> patches_;  // and of its patches.
};

// Implementation -----------------------------------------------------------------------------------

template <Scalar S>
void Recorder<S>::add_body(BodyId id, const BodyDef<S>& def, std::string name, S plane_size) {
  detail::require(number_of(id) == bodies_.size(), "Recorder: BodyId", id.index,
                  "must not be recorded already");
  typename Recording<S>::Body body;
  body.name = std::move(name);
  body.moves = def.motion != Motion::fixed;
  const auto add = [&](const Shape<S>& shape, const Transform<S>& X_BS) {
    const TriangleMesh<S> mesh = drawn_mesh<S>(shape, plane_size);
    const auto first = static_cast<std::uint32_t>(body.mesh.vertices.size());
    for (const Vec3<S>& v : mesh.vertices) body.mesh.vertices.push_back(X_BS * v);
    for (const auto& t : mesh.triangles) {
      body.mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    }
  };
  if (def.shape) add(*def.shape, {});
  for (const ShapeDef<S>& shape : def.shapes) add(shape.shape, shape.X_BS);
  body.poses.resize(recording_.times.size());
  body.was_there.resize(recording_.times.size(), false);
  recording_.bodies.push_back(std::move(body));
  bodies_.push_back(id);
}

template <Scalar S>
template <typename Backend>
void Recorder<S>::add_patch(const World<S, Backend>& world, PatchId id, std::string name) {
  const detail::SensorPatch<S>& sensors = world.patch(id);
  detail::require(std::find(patches_.begin(), patches_.end(), id) == patches_.end(),
                  "Recorder: PatchId", id.index, "must not be recorded already");
  typename Recording<S>::Patch patch;
  patch.name = std::move(name);
  patch.body = number_of(sensors.body);
  detail::require(patch.body < bodies_.size(), "Recorder: PatchId", id.index,
                  "must be on a body that is recorded");
  const Vec3<S>& center = world.body(sensors.body).center_B;
  for (std::size_t i = 0; i < sensors.length.size(); ++i) {
    patch.ends.push_back(center + sensors.start[i] + sensors.length[i] * sensors.direction[i]);
  }
  patch.forces.resize(recording_.times.size() * patch.ends.size(), Vec3<S>::Zero());
  recording_.patches.push_back(std::move(patch));
  patches_.push_back(id);
}

template <Scalar S>
template <typename Backend>
void Recorder<S>::observe(const World<S, Backend>& world) {
  const double dt = static_cast<double>(world.time_step());
  time_ += dt;
  std::vector<double>& times = recording_.times;
  // The step that ends next to the frame's instant; instants that long steps missed are left out.
  if (!times.empty() && time_ + dt / 2 < due_) return;
  for (std::size_t k = 0; k < patches_.size(); ++k) {
    detail::require(!world.contains(patches_[k]) ||
                        world.reading(patches_[k]).size() == recording_.patches[k].ends.size(),
                    "Recorder: PatchId", patches_[k].index,
                    "must be of the world it was added from");
  }
  due_ = (times.empty() || due_ + 1 / rate_ < time_ ? time_ : due_) + 1 / rate_;
  times.push_back(time_);
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    typename Recording<S>::Body& body = recording_.bodies[k];
    const bool is_there = world.contains(bodies_[k]);
    body.was_there.push_back(is_there);
    // Where it was last, for what looks at two frames at once.
    const Transform<S> last = body.poses.empty() ? Transform<S>{} : body.poses.back();
    body.poses.push_back(is_there ? world.pose(bodies_[k]) : last);
  }
  for (std::size_t k = 0; k < patches_.size(); ++k) {
    typename Recording<S>::Patch& patch = recording_.patches[k];
    if (!world.contains(patches_[k])) {
      patch.forces.resize(times.size() * patch.ends.size(), Vec3<S>::Zero());
      continue;
    }
    const PatchReading<S> felt = world.reading(patches_[k]);
    const detail::Vec3Array<S>& directions = world.patch(patches_[k]).direction;
    for (std::size_t i = 0; i < patch.ends.size(); ++i) {
      const Vec3<S> n = directions[i];
      Vec3<S> t1, t2;
      tangent_basis<S>(n, t1, t2);
      // The reading is what acts on the sensor's own body.
      patch.forces.push_back(felt.normal_force[i] * n - felt.shear_1[i] * t1 -
                             felt.shear_2[i] * t2);
    }
  }
}

}  // namespace bristle::inline BRISTLE_ABI
