/// @file
/// One number for the state of a world: equal states, equal bits.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/world/world.hpp>

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

namespace bristle::test {

/// FNV-1a over values, by their bytes.
class Hash {
 public:
  template <typename T>
  requires std::is_arithmetic_v<T> || std::is_enum_v<T>
  void add(const T& value) {
    const auto bytes = std::bit_cast<std::array<unsigned char, sizeof(T)>>(value);
    for (const unsigned char byte : bytes) value_ = (value_ ^ byte) * 0x100000001b3u;
  }
  template <typename Derived>
  void add(const Eigen::DenseBase<Derived>& values) {
    for (Eigen::Index i = 0; i < values.size(); ++i) add(values.derived().coeff(i));
  }
  template <typename T>
  void add(std::span<const T> values) {
    for (const T& value : values) add(value);
  }
  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325u;
};

/// Poses and velocities of some bodies, roots and readings of some patches, impulses of all
/// contacts.
template <Scalar S, typename Backend>
[[nodiscard]] std::uint64_t state_hash(const World<S, Backend>& world,
                                       std::span<const BodyId> bodies,
                                       std::span<const PatchId> patches) {
  Hash hash;
  hash.add(world.body_count());
  for (const BodyId id : bodies) {
    const Body<S>& body = world.body(id);
    hash.add(body.center_pose.translation);
    hash.add(body.center_pose.rotation.coeffs());
    hash.add(body.twist.linear);
    hash.add(body.twist.angular);
    hash.add(body.applied.force);
    hash.add(body.applied.torque);
    hash.add(body.mass);
    hash.add(body.filter.mask);
  }
  for (const PatchId id : patches) {
    const SensorPatch<S>& patch = world.patch(id);
    hash.add(patch.def.parameters.static_friction);
    for (std::size_t i = 0; i < patch.size(); ++i) {
      hash.add(patch.rooted_in[i].index);
      if (patch.rooted_in[i] == BodyId{}) continue;
      hash.add(patch.root_a[i]);
      hash.add(patch.root_b[i]);
    }
    const PatchReading<S> r = world.reading(id);
    hash.add(r.depth);
    hash.add(r.normal_force);
    hash.add(r.shear_1);
    hash.add(r.shear_2);
    hash.add(r.state);
    hash.add(r.wrench.force);
    hash.add(r.wrench.torque);
  }
  for (const CachedPoint<S>& point : world.contacts().points()) {
    for (const S impulse : point.impulse) hash.add(impulse);
  }
  hash.add(world.time_step());
  hash.add(world.def().gravity);
  return hash.value();
}

}  // namespace bristle::test
