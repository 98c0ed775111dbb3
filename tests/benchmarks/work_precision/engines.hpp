/// @file
/// Engines that a driver offers: by name, each in some settings.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenes/rigid/trial.hpp"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace bristle::work_precision {

/// An engine by name.
struct EngineFamily {
  std::string name;
  /// [-] Its settings, the defaults first.
  std::vector<std::string> settings;
  /// Sets a scene up for steps of `dt` [s].
  /// @throws scenes::Unsupported
  std::function<std::unique_ptr<scenes::Engine>(const scenes::Scene&, double dt,
                                                const std::string& setting)>
      make;
};

/// The engines of this program; each program links the driver that defines it.
[[nodiscard]] std::vector<EngineFamily> engine_families();

}  // namespace bristle::work_precision
