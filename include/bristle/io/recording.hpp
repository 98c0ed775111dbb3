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
  struct Body {
    std::string name{};
    /// True if the world moves it.
    bool moves = false;
    /// [m] Its look, in its frame.
    TriangleMesh<S> mesh{};
    /// [m] Frame by frame: its pose in the world, and whether it was there.
    std::vector<Transform<S>> poses{};
    std::vector<bool> was_there{};
  };
  struct Patch {
    std::string name{};
    /// [-] Number of the body that carries it.
    std::size_t body = 0;
    /// [m] Ends of the sensors' rays, and [1] the rays' directions, in the body's frame.
    std::vector<Vec3<S>> ends{};
    std::vector<Vec3<S>> directions{};
    /// [N] Frame by frame, sensor by sensor: the force on what the sensor touches, in the body's
    /// frame; [1] its depth in [0, 1]; [-] free, stuck, or slipping in a step since the last frame.
    std::vector<Vec3<S>> forces{};
    std::vector<float> depths{};
    std::vector<SensorState> states{};
  };
  /// One point in which shapes pressed on each other.
  struct Contact {
    /// [-] Number of the body that is pressed.
    std::size_t body = 0;
    /// [m] Where, and [N] with which force on that body, world axes.
    Vec3<S> point = Vec3<S>::Zero();
    Vec3<S> force = Vec3<S>::Zero();
  };
  struct Joint {
    std::string name{};
    /// [-] Number of its body B.
    std::size_t body = 0;
    /// [m] Its frame in that of body B; its axis is x.
    Transform<S> X_BJ{};
    /// True if it turns about its axis, false if it slides along it. Those that have none keep no numbers.
    bool turns = false;
    bool slides = false;
    /// [m; rad] Frame by frame: its position; [N; N m] the force of its motor.
    std::vector<S> positions{};
    std::vector<S> motor_forces{};
  };
  /// A number that the caller named.
  struct Channel {
    std::string name{};
    std::string unit{};
    /// [-] Frame of the first value: it was not known before.
    std::size_t first_frame = 0;
    std::vector<double> values{};
  };

  /// [s] Of the frames, since the recorder's first step; ascending.
  std::vector<double> times{};
  std::vector<Body> bodies{};
  std::vector<Patch> patches{};
  /// Frame by frame.
  std::vector<std::vector<Contact>> contacts{};
  std::vector<Joint> joints{};
  std::vector<Channel> channels{};
};

}  // namespace bristle::inline BRISTLE_ABI
