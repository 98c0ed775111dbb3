/// @file
/// Common base of the engines' hosts: the sensors, and the map between mirrored and engine bodies.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/hosts/host_sensors.hpp>

#include <cstddef>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// Sensors in an engine that identifies bodies by a `Key`: a pointer, or a number. In double, since
/// engines are, or can be. Bodies added to the mirror directly have no key. Nothing senses them
/// unless they are fixed.
template <typename Key, typename Backend>
class EngineHost {
 public:
  /// The sensors, with the report of the last step.
  [[nodiscard]] HostSensors<double, Backend>& sensors() noexcept { return sensors_; }
  /// Mirror of the engine's world, with patches and readings.
  [[nodiscard]] World<double, Backend>& world() noexcept { return sensors_.world(); }

  /// The mirrored body of an engine body, if any.
  [[nodiscard]] std::optional<BodyId> find(Key key) const {
    const auto found = ids_.find(key);
    if (found == ids_.end() || !sensors_.world().contains(found->second)) return {};
    return found->second;
  }
  /// Removes a mirrored body, with its patches, before the engine destroys the original. Sensors in
  /// contact with it let go.
  void forget(Key key) {
    if (const auto id = find(key)) world().remove_body(*id);
    ids_.erase(key);
  }

 protected:
  EngineHost() = default;
  ~EngineHost() = default;

  /// Adds sensors to the mirrored body of `key`. A body that was mirrored for them is forgotten if
  /// they are refused.
  /// @param mirror  mirror() mirrors that body if needed and returns its id.
  template <typename Mirror>
  PatchId add_patch_to(Key key, const PatchDef<double>& def, Mirror&& mirror) {
    struct Undo {
      EngineHost* host;
      Key key;
      ~Undo() {
        if (host != nullptr) host->forget(key);
      }
    } undo{find(key) ? nullptr : this, key};
    const PatchId patch = world().add_patch(mirror(), def);
    undo.host = nullptr;
    return patch;
  }
  /// Mirrors an engine body that is not mirrored yet.
  /// @param X_WB            [m] Pose of its frame.
  /// @param center_of_mass  [m] In its frame.
  BodyId insert(Key key, Motion motion, const Transform<double>& X_WB,
                const Vec3<double>& center_of_mass, std::vector<ShapeDef<double>> shapes) {
    BodyDef<double> def;
    def.motion = motion;
    def.center_of_mass = center_of_mass;
    def.shapes = std::move(shapes);
    def.position = X_WB.translation;
    def.orientation = X_WB.rotation;
    const BodyId id = world().add_body(def);
    ids_[key] = id;
    if (entries_.size() <= id.index) entries_.resize(id.index + std::size_t(1));
    entries_[id.index] = {id, key};
    return id;
  }
  /// Key of the engine body of a mirrored one; nothing if a caller added it.
  [[nodiscard]] std::optional<Key> key_of(BodyId id) const {
    if (id.index >= entries_.size() || entries_[id.index].id != id) return {};
    return entries_[id.index].key;
  }

 private:
  struct Entry {
    BodyId id{};
    Key key{};
  };

  HostSensors<double, Backend> sensors_;
  std::unordered_map<Key, BodyId> ids_;
  std::vector<Entry> entries_;  // By index of mirrored bodies.
};

}  // namespace bristle::inline BRISTLE_ABI
