/// @file
/// What became of an AMBF description in a world: names and what they stand for.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/dynamics/joint.hpp>
#include <bristle/io/adf_limits.hpp>
#include <bristle/io/adf_model.hpp>
#include <bristle/io/adf_report.hpp>
#include <bristle/sensors/patch.hpp>
#include <bristle/world/proximity.hpp>

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace bristle {

/// Things under the names of a description, in the order of the file.
template <typename T>
class AdfNames {
 public:
  struct Entry {
    std::string qualified;
    std::string key;
    std::string name;
    T value;
  };

  void add(const AdfItem& item, T value) {
    by_qualified_.emplace(item.qualified, entries_.size());
    by_key_.emplace(item.key, entries_.size());
    entries_.push_back({item.qualified, item.key, item.name, std::move(value)});
  }

  /// What a name stands for: the one of that qualified name, or key, or the only one that calls
  /// itself so, or the only one whose qualified name has it as a part. Null where there is none, or
  /// several.
  [[nodiscard]] const T* find(std::string_view name) const {
    for (const auto* names : {&by_qualified_, &by_key_}) {
      const auto at = names->find(name);
      if (at != names->end()) return &entries_[at->second].value;
    }
    std::size_t named = 0, matching = 0;
    const T* found = nullptr;
    const T* part = nullptr;
    for (const Entry& entry : entries_) {
      if (entry.name == name && ++named == 1) found = &entry.value;
      if (entry.qualified.find(name) != std::string::npos && ++matching == 1) part = &entry.value;
    }
    if (named > 0) return named == 1 ? found : nullptr;
    return matching == 1 ? part : nullptr;
  }
  [[nodiscard]] T* find(std::string_view name) {
    return const_cast<T*>(std::as_const(*this).find(name));
  }

  /// The same, for names that must be there.
  /// @throws InvalidArgument when the name stands for nothing, or for several things.
  [[nodiscard]] const T& at(std::string_view name) const {
    const T* found = find(name);
    if (found == nullptr) {
      detail::raise(InvalidArgument("AdfNames::at: name", std::string(name),
                                    "must be a name of the description, or a part of just one"));
    }
    return *found;
  }
  [[nodiscard]] T& at(std::string_view name) {
    return const_cast<T&>(std::as_const(*this).at(name));
  }

  [[nodiscard]] std::size_t size() const noexcept { return entries_.size(); }
  [[nodiscard]] auto begin() const noexcept { return entries_.begin(); }
  [[nodiscard]] auto end() const noexcept { return entries_.end(); }

 private:
  std::vector<Entry> entries_;
  std::map<std::string, std::size_t, std::less<>> by_qualified_;
  std::map<std::string, std::size_t, std::less<>> by_key_;
};

/// A proximity sensor and the body that carries it: `world.sense(p.carrier, p.rays)` reads it.
template <Scalar S>
struct AdfProximity {
  BodyId carrier{};
  ProximityArray<S> rays;
};

/// A description that has been added to a world.
template <Scalar S>
struct AdfScene {
  AdfNames<BodyId> bodies;
  AdfNames<JointId> joints;
  AdfNames<PatchId> patches;
  AdfNames<AdfProximity<S>> proximity;
  /// What was not taken as it stands, from reading and from building.
  AdfReport report;
};

/// How a description becomes part of a world.
template <Scalar S>
struct AdfBuildDef {
  /// [m] Pose of the model's frame in the world.
  Transform<S> X_WM{};
  /// [-] Whether joints with a controller are held where they stand, by a spring of its P and a
  /// damper of its D. Else joints are free until they are given a drive, as in AMBF.
  bool hold_joints = false;
  /// [s] Step of the loop for which the file's damping was chosen: constants that the format means
  /// per step are taken for this one.
  S authored_step = S(1e-3);
  /// [-] How the forces of patches enter the step.
  Integration integration = Integration::automatic;
  /// [-] Readings of the law, but for what friction grows with, which each sensor says.
  LawOptions law{};
  /// [-] What meshes and their rays may ask for.
  AdfLimits limits{};
};

}  // namespace bristle
