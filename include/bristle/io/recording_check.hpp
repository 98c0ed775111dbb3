/// @file
/// Checks that a recording can be written.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/io/gltf_buffer.hpp>
#include <bristle/io/recording.hpp>
#include <bristle/io/utf8.hpp>

#include <cmath>
#include <cstddef>
#include <vector>

namespace bristle::inline BRISTLE_ABI::detail {

/// Checks sizes, numbers and names of a recording.
template <Scalar S>
class RecordingCheck {
 public:
  explicit RecordingCheck(const Recording<S>& recording) : recording_(recording) {}

  /// @throws InvalidArgument naming what is wrong.
  void run() const {
    check_times();
    for (const auto& body : recording_.bodies) check(body);
    for (const auto& patch : recording_.patches) check(patch);
    for (const auto& joint : recording_.joints) check(joint);
    for (const auto& channel : recording_.channels) check(channel);
    check_contacts();
  }

 private:
  [[nodiscard]] std::size_t frames() const { return recording_.times.size(); }

  void check_times() const {
    require(frames() > 0, "glb: Recording::times.size()", 0, "must not be 0");
    float last = -1;
    for (const double t : recording_.times) {
      const float time = static_cast<float>(t - recording_.times.front());
      require(std::isfinite(time) && time > last, "glb: Recording::times", t,
              "must ascend, in float and from the first");
      last = time;
    }
  }
  static void require_size(const char* field, std::size_t size, std::size_t wanted,
                           const char* rule = "must be that of the times") {
    require(size == wanted, field, size, rule);
  }
  void require_body(const char* field, std::size_t body) const {
    require(body < recording_.bodies.size(), field, body, "must be the number of a body");
  }

  void check(const typename Recording<S>::Body& body) const {
    require_utf8("glb: Recording::Body::name", body.name);
    require_size("glb: Recording::Body::poses.size()", body.poses.size(), frames());
    require_size("glb: Recording::Body::was_there.size()", body.was_there.size(), frames());
    for (const Transform<S>& pose : body.poses) {
      require(is_finite_in_float(pose.translation) && pose.rotation.coeffs().allFinite(),
              "glb: Recording::Body::poses", body.name.c_str(), "must be finite in float");
    }
    for (const Vec3<S>& v : body.mesh.vertices) {
      require(is_finite_in_float(v), "glb: Recording::Body::mesh", body.name.c_str(),
              "must be finite in float");
    }
  }
  void check(const typename Recording<S>::Patch& patch) const {
    require_utf8("glb: Recording::Patch::name", patch.name);
    require_body("glb: Recording::Patch::body", patch.body);
    const std::size_t sensors = patch.ends.size();
    require_size("glb: Recording::Patch::directions.size()", patch.directions.size(), sensors,
                 "must be that of the ends");
    const char* const rule = "must be that of the times times that of the ends";
    require_size("glb: Recording::Patch::forces.size()", patch.forces.size(), frames() * sensors,
                 rule);
    require_size("glb: Recording::Patch::depths.size()", patch.depths.size(), frames() * sensors,
                 rule);
    require_size("glb: Recording::Patch::states.size()", patch.states.size(), frames() * sensors,
                 rule);
    for (const auto* values : {&patch.ends, &patch.directions, &patch.forces}) {
      for (const Vec3<S>& v : *values) {
        require(std::isfinite(static_cast<float>(v.squaredNorm())), "glb: Recording::Patch",
                patch.name.c_str(), "must have finite forces and rays in float");
      }
    }
    for (const float depth : patch.depths) {
      require(depth >= 0 && depth <= 1, "glb: Recording::Patch::depths", depth,
              "must be in [0, 1]");
    }
  }
  void check(const typename Recording<S>::Joint& joint) const {
    require_utf8("glb: Recording::Joint::name", joint.name);
    require_body("glb: Recording::Joint::body", joint.body);
    require(is_finite_in_float(joint.X_BJ.translation) && joint.X_BJ.rotation.coeffs().allFinite(),
            "glb: Recording::Joint::X_BJ", joint.name.c_str(), "must be finite in float");
    require_size("glb: Recording::Joint::positions.size()", joint.positions.size(), frames());
    require_size("glb: Recording::Joint::motor_forces.size()", joint.motor_forces.size(), frames());
    for (const auto* values : {&joint.positions, &joint.motor_forces}) {
      for (const S x : *values) {
        require(std::isfinite(static_cast<float>(x)), "glb: Recording::Joint", x,
                "must be finite in float");
      }
    }
  }
  void check(const typename Recording<S>::Channel& channel) const {
    require_utf8("glb: Recording::Channel::name", channel.name);
    require_utf8("glb: Recording::Channel::unit", channel.unit);
    require(
        channel.first_frame <= frames() && channel.values.size() == frames() - channel.first_frame,
        "glb: Recording::Channel::values.size()", channel.values.size(),
        "must be that of the times from first_frame on");
    for (const double x : channel.values) {
      require(std::isfinite(static_cast<float>(x)), "glb: Recording::Channel", x,
              "must be finite in float");
    }
  }
  void check_contacts() const {
    // None are kept by those who do not know of them.
    if (recording_.contacts.empty()) return;
    require_size("glb: Recording::contacts.size()", recording_.contacts.size(), frames());
    for (const auto& frame : recording_.contacts) {
      for (const auto& contact : frame) {
        require_body("glb: Recording::Contact::body", contact.body);
        require(is_finite_in_float(contact.point) && is_finite_in_float(contact.force),
                "glb: Recording::Contact", contact.body, "must be finite in float");
      }
    }
  }

  const Recording<S>& recording_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
