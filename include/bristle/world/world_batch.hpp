/// @file
/// Many worlds of one scene that step together, for training a learner.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/error.hpp>
#include <bristle/core/kernel_scratch.hpp>
#include <bristle/core/parallel.hpp>
#include <bristle/sensors/tactile_image.hpp>
#include <bristle/sensors/taxel_points.hpp>
#include <bristle/world/world.hpp>
#include <bristle/world/world_constants.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <span>
#include <string>
#include <utility>

namespace bristle::inline BRISTLE_ABI {

/// Copies of one world. They share its shapes and the rays of its patches, and nothing else.
///
/// `WorldBatch<float> batch(scene, 1024, pool.hook())`, then, again and again, `batch.step(8)`,
/// `batch.gather_taxels(pads, images)` and `batch.reset(batch.failed())`: examples/18_batch.cpp.
///
/// Each world behaves as it would alone, to the last bit, for any number of threads and worlds.
/// Seed random values by the index of the world. Handles of the original are valid in all worlds.
///
/// A mask has one byte a world, nonzero selects. An empty mask selects all.
template <Scalar S, typename Backend = AnalyticBackend>
class WorldBatch {
 public:
  /// One byte a world: nonzero selects it. An empty mask selects all.
  using Mask = std::span<const std::uint8_t>;

  /// @param origin  World that all worlds start as and are reset to. It is copied.
  /// @param count   [-] Number of worlds, > 0.
  /// @param parallel_for  Steps worlds at the same time. Each world uses one thread, whatever hook
  ///                      the original has. A world that is assigned to brings its own.
  /// @throws InvalidArgument when `count` is 0 or the hook is empty.
  WorldBatch(const World<S, Backend>& origin, std::size_t count,
             ParallelFor parallel_for = serial_for);

  /// [-] Number of worlds.
  [[nodiscard]] std::size_t size() const noexcept { return worlds_.size(); }
  /// One world of the batch.
  /// @throws InvalidArgument when there is no world of this index.
  [[nodiscard]] World<S, Backend>& world(std::size_t number) {
    require_number(number);
    return worlds_[number];
  }
  /// One world of the batch, for reading.
  /// @throws InvalidArgument when there is no world of this index.
  [[nodiscard]] const World<S, Backend>& world(std::size_t number) const {
    require_number(number);
    return worlds_[number];
  }

  /// Calls visit(index, world) for the worlds of a mask, several at the same time.
  /// @throws InvalidArgument when the mask is of another size. Otherwise the exception of `visit`
  ///         with the lowest world index. The other worlds are visited all the same.
  template <typename Visit>
  void for_each(Visit&& visit, Mask mask = {});

  /// Advances all worlds by some steps each. One call for several steps is cheaper: a world stays
  /// in cache.
  void step(std::size_t steps = 1);

  /// [-] One byte a world: 1 if a step of this batch failed since the last reset. Bodies were left
  /// standing then (`StepReport::discarded_islands`, `frozen_bodies`). All worlds go on. Steps by
  /// `world(i).step()` are not counted.
  [[nodiscard]] Mask failed() const noexcept { return {failed_.data(), failed_.size()}; }

  /// Resets the worlds of a mask to their start, masses and materials included.
  /// @throws InvalidArgument when the mask is of another size.
  void reset(Mask mask = {}) { reset_to(origin_, mask); }
  /// Resets the worlds of a mask to the state of another world, masses and materials included, such
  /// as a copy of the original that already holds its part. Handles of that world then name the
  /// same things in them.
  /// @throws InvalidArgument when the mask is of another size.
  void reset_to(const World<S, Backend>& start, Mask mask = {});

  /// Writes bodies to out[world][body][13]: position of the body frame [m], its quaternion x, y, z,
  /// w, velocity of the centre of mass [m/s], angular velocity [rad/s]. World axes.
  /// @throws InvalidArgument when `out` has another size or a world lacks a body. Nothing is
  ///         written then. The same holds for the functions below.
  void gather_bodies(std::span<const BodyId> bodies, std::span<S> out) const;
  /// Writes joints to out[world][joint][2]: position and velocity, as in `JointReading`.
  void gather_joints(std::span<const JointId> joints, std::span<S> out) const;
  /// Writes readings to out[world][patch][channel][sensor], with the channels of `TactileChannel`
  /// in its order and units. Sensors of a `sensor_grid` are image rows. All patches must have
  /// equally many sensors.
  void gather_taxels(std::span<const PatchId> patches, std::span<S> out) const;
  /// Writes readings to out[world][patch][sensor][6] as sets of points: displacement dx, dy, dz
  /// [m] and force Fx, Fy, Fz [N] in the axes of the patch's body (`World::taxel_points`). All
  /// patches must have equally many sensors.
  void gather_points(std::span<const PatchId> patches, std::span<S> out) const;
  /// Writes the number of sensors in contact to out[world][patch].
  void gather_touching(std::span<const PatchId> patches, std::span<std::uint32_t> out) const;

 private:
  void require_number(std::size_t number) const {
    detail::require(number < size(), "WorldBatch: number of a world", number,
                    "must be below the number of worlds");
  }
  void require_mask(Mask mask) const {
    detail::require(mask.empty() || mask.size() == size(), "WorldBatch: mask.size()", mask.size(),
                    "must be 0 or the number of worlds");
  }
  static void require_size(std::size_t has, std::size_t needs) {
    detail::require(has == needs, "WorldBatch: out.size()", has,
                    "must be " + std::to_string(needs));
  }
  /// Runs task(index of the task, first world, end), for all worlds.
  template <typename Task>
  void in_tasks(const Task& task) const {
    parallel_for_(steppers_.size(), [&](std::size_t k) {
      task(k, k * per_task_, std::min(size(), (k + 1) * per_task_));
    });
  }
  /// Throws InvalidArgument unless all worlds have these handles.
  template <typename Id>
  void require_handles(std::span<const Id> ids) const;
  [[nodiscard]] std::size_t require_equal_patches(std::span<const PatchId> patches) const;
  /// Writes `width` numbers a world and handle: write(world, id, first number).
  template <typename Id, typename T, typename Write>
  void gather(std::span<const Id> ids, std::size_t width, std::span<T> out,
              const Write& write) const;

  World<S, Backend> origin_;
  detail::DynamicArray<World<S, Backend>> worlds_;
  detail::DynamicArray<std::uint8_t> failed_;
  std::size_t per_task_;
  detail::DynamicArray<detail::KernelScratch<detail::WorldKernels<S>>> steppers_;
  ParallelFor parallel_for_;
};

// Implementation ----------------------------------------------------------------------------------

template <Scalar S, typename Backend>
WorldBatch<S, Backend>::WorldBatch(const World<S, Backend>& origin, std::size_t count,
                                   ParallelFor parallel_for)
    : origin_(origin),
      per_task_(std::clamp<std::size_t>(count / detail::chosen::fewest_batch_tasks, 1,
                                        detail::chosen::most_worlds_per_task)),
      parallel_for_(std::move(parallel_for)) {
  detail::require(count > 0, "WorldBatch: count", count, "must be > 0");
  detail::require(bool(parallel_for_), "WorldBatch: parallel_for", "empty", "must be callable");
  // The threads of the hook are busy with worlds.
  origin_.state_.def.parallel_for = serial_for;
  worlds_.assign(count, origin_);
  failed_.assign(count, std::uint8_t(0));
  steppers_.assign((count + per_task_ - 1) / per_task_, origin_.stepper_);
}

template <Scalar S, typename Backend>
template <typename Visit>
void WorldBatch<S, Backend>::for_each(Visit&& visit, Mask mask) {
  require_mask(mask);
  const auto visit_some = [&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) {
      if (mask.empty() || mask[i] != 0) visit(i, worlds_[i]);
    }
  };
#if defined(__cpp_exceptions)
  // No exception may leave a task. Each task stores its first one.
  detail::DynamicArray<std::exception_ptr> errors(steppers_.size());
  in_tasks([&](std::size_t task, std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) {
      try {
        visit_some(i, i + 1);
      } catch (...) {
        if (!errors[task]) errors[task] = std::current_exception();
      }
    }
  });
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
#else
  in_tasks([&](std::size_t, std::size_t first, std::size_t end) { visit_some(first, end); });
#endif
}

template <Scalar S, typename Backend>
void WorldBatch<S, Backend>::step(std::size_t steps) {
  in_tasks([&](std::size_t task, std::size_t first, std::size_t end) {
    const auto& stepper = steppers_[task];
    for (std::size_t i = first; i < end; ++i) {
      World<S, Backend>& world = worlds_[i];
      for (std::size_t k = 0; k < steps; ++k) {
        stepper.kernels().step(stepper.get(), world.state_);
        const StepReport<S>& report = world.report();
        if (report.discarded_islands + report.frozen_bodies > 0) failed_[i] = 1;
      }
    }
  });
}

template <Scalar S, typename Backend>
void WorldBatch<S, Backend>::reset_to(const World<S, Backend>& start, Mask mask) {
  for_each(
      [&](std::size_t i, World<S, Backend>& world) {
        if (&world != &start) world.state_ = start.state_;
        failed_[i] = 0;
      },
      mask);
}

template <Scalar S, typename Backend>
template <typename Id>
void WorldBatch<S, Backend>::require_handles(std::span<const Id> ids) const {
  for (const World<S, Backend>& world : worlds_) {
    for (const Id id : ids) {
      detail::require(world.contains(id), "WorldBatch: handle of a world", id,
                      "must name what all worlds have");
    }
  }
}

template <Scalar S, typename Backend>
template <typename Id, typename T, typename Write>
void WorldBatch<S, Backend>::gather(std::span<const Id> ids, std::size_t width, std::span<T> out,
                                    const Write& write) const {
  require_handles(ids);
  require_size(out.size(), size() * ids.size() * width);
  in_tasks([&](std::size_t, std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) {
      for (std::size_t k = 0; k < ids.size(); ++k) {
        write(worlds_[i], ids[k], out.data() + (i * ids.size() + k) * width);
      }
    }
  });
}

template <Scalar S, typename Backend>
void WorldBatch<S, Backend>::gather_bodies(std::span<const BodyId> bodies, std::span<S> out) const {
  gather<BodyId>(bodies, 13, out, [](const World<S, Backend>& world, BodyId id, S* to) {
    const Transform<S> X = world.pose(id);
    const Twist<S>& twist = world.body(id).twist;
    to = std::copy_n(X.translation.data(), 3, to);
    to = std::copy_n(X.rotation.coeffs().data(), 4, to);
    to = std::copy_n(twist.linear.data(), 3, to);
    std::copy_n(twist.angular.data(), 3, to);
  });
}

template <Scalar S, typename Backend>
void WorldBatch<S, Backend>::gather_joints(std::span<const JointId> joints,
                                           std::span<S> out) const {
  gather<JointId>(joints, 2, out, [](const World<S, Backend>& world, JointId id, S* to) {
    const JointReading<S> reading = world.reading(id);
    to[0] = reading.position;
    to[1] = reading.velocity;
  });
}

/// @return [-] Sensors of each of the patches.
template <Scalar S, typename Backend>
std::size_t WorldBatch<S, Backend>::require_equal_patches(std::span<const PatchId> patches) const {
  require_handles(patches);
  const std::size_t sensors = patches.empty() ? 0 : worlds_[0].patch(patches.front()).size();
  for (const World<S, Backend>& world : worlds_) {
    for (const PatchId id : patches) {
      detail::require(world.patch(id).size() == sensors, "WorldBatch: sensors of a patch",
                      world.patch(id).size(), "must be as many as those of the first one");
    }
  }
  return sensors;
}

template <Scalar S, typename Backend>
void WorldBatch<S, Backend>::gather_taxels(std::span<const PatchId> patches,
                                           std::span<S> out) const {
  const std::size_t sensors = require_equal_patches(patches);
  gather<PatchId>(patches, tactile_channel_count * sensors, out,
                  [](const World<S, Backend>& world, PatchId id, S* to) {
                    const PatchReading<S> reading = world.reading(id);
                    for (const std::span<const S> channel :
                         {reading.depth, reading.normal_force, reading.shear_1, reading.shear_2}) {
                      to = std::copy(channel.begin(), channel.end(), to);
                    }
                  });
}

template <Scalar S, typename Backend>
void WorldBatch<S, Backend>::gather_points(std::span<const PatchId> patches,
                                           std::span<S> out) const {
  const std::size_t width = detail::taxel_point_size * require_equal_patches(patches);
  gather<PatchId>(patches, width, out, [width](const World<S, Backend>& world, PatchId id, S* to) {
    world.taxel_points(id, {to, width});
  });
}

template <Scalar S, typename Backend>
void WorldBatch<S, Backend>::gather_touching(std::span<const PatchId> patches,
                                             std::span<std::uint32_t> out) const {
  gather<PatchId>(patches, 1, out,
                  [](const World<S, Backend>& world, PatchId id, std::uint32_t* to) {
                    *to = static_cast<std::uint32_t>(world.reading(id).touching());
                  });
}

}  // namespace bristle::inline BRISTLE_ABI
