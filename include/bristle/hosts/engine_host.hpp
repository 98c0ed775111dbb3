/// @file
/// What the hosts of engines share: the sensors, and which mirrored body is whose.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/hosts/host_sensors.hpp>

#include <cstddef>
#include <optional>
#include <unordered_map>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// Sensors in an engine whose bodies are known by a `Key`: a pointer, or a number. In double, since
/// engines are, or can be. Bodies that a caller adds to the mirror himself have no key: unless they
/// are fixed, nobody sees them.
template <typename Key, typename Backend>
class EngineHost {
 public:
  /// The sensors: what the last step did is in their report.
  [[nodiscard]] HostSensors<double, Backend>& sensors() noexcept { return sensors_; }
  /// The mirror of the engine's world, with patches and readings.
  [[nodiscard]] World<double, Backend>& world() noexcept { return sensors_.world(); }

  /// The mirrored body of one of the engine's, if there is one.
  [[nodiscard]] std::optional<BodyId> find(Key key) const {
    const auto found = ids_.find(key);
    if (found == ids_.end() || !sensors_.world().contains(found->second)) return {};
    return found->second;
  }
  /// Ends the mirrored body, with its patches, of a body that the engine is to lose. What sensed it
  /// lets go.
  void forget(Key key) {
    if (const auto id = find(key)) world().remove_body(*id);
    ids_.erase(key);
  }

 protected:
  EngineHost() = default;
  ~EngineHost() = default;

  /// Mirrors a body of the engine that is not mirrored yet.
  BodyId insert(Key key, const BodyDef<double>& def) {
    const BodyId id = world().add_body(def);
    ids_[key] = id;
    if (entries_.size() <= id.index) entries_.resize(id.index + std::size_t(1));
    entries_[id.index] = {id, key};
    return id;
  }
  /// Whose mirrored body this is: nothing for one that a caller has added.
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
  std::vector<Entry> entries_;  // By slots of mirrored bodies.
};

}  // namespace bristle::inline BRISTLE_ABI
