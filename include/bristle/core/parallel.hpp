/// @file
/// The hook through which a host lends its worker threads. Sums that use it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <new>

namespace bristle::common {

/// The default hook: one task after the other on the calling thread. The type lies outside of the
/// namespace that names the registers of a file. So `is_serial` recognises it in all code of a
/// program, also in the kernels of `bristle::compiled`.
struct SerialFor {
  /// Runs task(i) for every i in [0, count), in ascending order.
  void operator()(std::size_t count, const std::function<void(std::size_t)>& task) const {
    for (std::size_t i = 0; i < count; ++i) task(i);
  }
};

}  // namespace bristle::common

namespace bristle::inline BRISTLE_ABI {

/// Runs task(i) once for every i in [0, count). Any order and any threads are allowed. Returns when
/// all are done. Tasks never write to the same place. So results do not depend on the schedule.
using ParallelFor =
    std::function<void(std::size_t count, const std::function<void(std::size_t)>& task)>;

/// Hook that runs all tasks in the calling thread, in ascending order.
inline constexpr common::SerialFor serial_for{};

/// Returns whether a hook is known to be `serial_for`. Work need not be divided for it. Without
/// run-time type information no hook is.
[[nodiscard]] bool is_serial(const ParallelFor& parallel_for);

/// Adds up part(first, end, sum) over [0, count) in ranges of `size`. Every range starts from its
/// own `Sum{}`, and ranges are added in their order. So the rounding is the same on one thread and
/// on many. Allocates nothing.
/// @param fewest_shared  [-] The hook is called for no fewer ranges than this.
template <typename Sum, typename Part>
[[nodiscard]] Sum sum_in_ranges(std::size_t count, std::size_t size, std::size_t fewest_shared,
                                const ParallelFor& parallel_for, const Part& part);

// Implementation ----------------------------------------------------------------------------------

inline bool is_serial(const ParallelFor& parallel_for) {
#if defined(__cpp_rtti)
  return parallel_for.target<common::SerialFor>() != nullptr;
#else
  (void)parallel_for;
  return false;
#endif
}

namespace detail {

/// Room for a T, which exists only from `make` to `destroy`. The caller of `make` calls `destroy`.
template <typename T>
class Storage {
 public:
  Storage() {}
  Storage(const Storage&) = delete;
  Storage& operator=(const Storage&) = delete;
  ~Storage() {}
  T& make() { return *::new (static_cast<void*>(&value_)) T{}; }
  [[nodiscard]] const T& value() const { return value_; }
  void destroy() { std::destroy_at(&value_); }

 private:
  union {
    T value_;
  };
};

}  // namespace detail

template <typename Sum, typename Part>
Sum sum_in_ranges(std::size_t count, std::size_t size, std::size_t fewest_shared,
                  const ParallelFor& parallel_for, const Part& part) {
  const std::size_t ranges = (count + size - 1) / size;
  const auto add_range = [&](std::size_t k, Sum& sum) {
    part(k * size, std::min(count, (k + 1) * size), sum);
  };
  Sum total{};
  if (ranges <= 1) {
    add_range(0, total);
  } else if (ranges < fewest_shared || is_serial(parallel_for)) {
    for (std::size_t k = 0; k < ranges; ++k) {
      Sum sum{};
      add_range(k, sum);
      total += sum;
    }
  } else {
    // As many ranges at a time as there is room for. The thread that adds up a range also
    // constructs its sum. Sums of contacts are 44 KiB in registers of 64 bytes. One thread would
    // write them before the others start.
    std::array<detail::Storage<Sum>, 32> sums;
    for (std::size_t first = 0; first < ranges; first += sums.size()) {
      const std::size_t some = std::min(sums.size(), ranges - first);
      const auto task = [&](std::size_t k) { add_range(first + k, sums[k].make()); };
      parallel_for(some, std::cref(task));
      for (std::size_t k = 0; k < some; ++k) {
        total += sums[k].value();
        sums[k].destroy();
      }
    }
  }
  return total;
}

}  // namespace bristle::inline BRISTLE_ABI
