/// @file
/// A scene of AMBF that a launch file lists: several descriptions, and their world.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/io/adf/adf_model.hpp>
#include <bristle/io/adf/adf_report.hpp>
#include <bristle/math/types.hpp>

#include <optional>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// A scene of several descriptions, in the order in which AMBF loads them.
struct AdfLaunch {
  /// [m/s^2] Gravity of the world file; unset: not given, which is (0, 0, -9.81) in AMBF. Models
  /// without gravity of their own have it already.
  std::optional<Vec3<double>> gravity{};
  /// [-] The world's environment, if it has one, and then the models that were asked for.
  std::vector<detail::AdfModel> models{};
  /// Parts of the launch and world file that are not in the models.
  AdfReport report{};
};

}  // namespace bristle::inline BRISTLE_ABI
