/// @file
/// The data of a replay.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/meshes/triangle_mesh.hpp>
#include <bristle/math/transform.hpp>
#include <bristle/sensors/reading.hpp>

#include <cstddef>
#include <string>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// The contents of a replay. Frames are instants; all vectors that run over frames are as long as
/// `times`. Names are UTF-8.
template <Scalar S>
struct Recording {
  /// A body and its motion.
  struct Body {
    /// Name in the replay.
    std::string name{};
    /// True if the world moves it.
    bool moves = false;
    /// [m] Its look, in its frame.
    TriangleMesh<S> mesh{};
    /// [m] Frame by frame: its pose in the world.
    std::vector<Transform<S>> poses{};
    /// Frame by frame: true if the world had the body.
    std::vector<bool> was_there{};
  };
  /// A tactile patch and its readings.
  struct Patch {
    /// Name in the replay.
    std::string name{};
    /// [-] Number of the body that carries it.
    std::size_t body = 0;
    /// [m] Ends of the sensors' rays, in the body's frame.
    std::vector<Vec3<S>> ends{};
    /// [1] Unit directions of the sensors' rays, in the body's frame.
    std::vector<Vec3<S>> directions{};
    /// [N] Frame by frame, sensor by sensor: the force on the body that the sensor touches, in the
    /// carrier's frame.
    std::vector<Vec3<S>> forces{};
    /// [1] Frame by frame, sensor by sensor: depth in [0, 1].
    std::vector<float> depths{};
    /// [-] Frame by frame, sensor by sensor: free, stuck, or slipping in a step since the last
    /// frame.
    std::vector<SensorState> states{};
  };
  /// One point in which shapes pressed on each other. A replay draws its force without a world, so
  /// it names a recorded body and no shapes.
  struct Contact {
    /// [-] Number of the body that is pressed.
    std::size_t body = 0;
    /// [m] Position in the world.
    Vec3<S> point = detail::zero<Vec3<S>>();
    /// [N] Force on that body, world axes.
    Vec3<S> force = detail::zero<Vec3<S>>();
  };
  /// A joint and its motion.
  struct Joint {
    /// Name in the replay.
    std::string name{};
    /// [-] Number of its body B.
    std::size_t body = 0;
    /// [m] Its frame in that of body B; its axis is x.
    Transform<S> X_BJ{};
    /// True if it turns about its axis. A joint that neither turns nor slides keeps no numbers.
    bool turns = false;
    /// True if it slides along its axis.
    bool slides = false;
    /// [m; rad] Frame by frame: its position.
    std::vector<S> positions{};
    /// [N; N m] Frame by frame: the force of its motor.
    std::vector<S> motor_forces{};
  };
  /// A number that the caller named.
  struct Channel {
    /// Name in the replay.
    std::string name{};
    /// Unit of the values. Empty for none.
    std::string unit{};
    /// [-] Frame of the first value: it was not known before.
    std::size_t first_frame = 0;
    /// Values, one a frame from `first_frame` on.
    std::vector<double> values{};
  };

  /// [s] Of the frames, since the recorder's first step; ascending.
  std::vector<double> times{};
  /// Bodies. Other parts name them by their number here.
  std::vector<Body> bodies{};
  /// Tactile patches.
  std::vector<Patch> patches{};
  /// Contacts, frame by frame.
  std::vector<std::vector<Contact>> contacts{};
  /// Joints.
  std::vector<Joint> joints{};
  /// Numbers that the caller named.
  std::vector<Channel> channels{};
};

}  // namespace bristle::inline BRISTLE_ABI
