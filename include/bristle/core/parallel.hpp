/// @file
/// The hook through which a host lends its worker threads, and sums that it may share out.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <new>

namespace bristle::inline BRISTLE_ABI {

/// Runs task(i) once for every i in [0, count), in any order and on any threads, and returns when
/// all are done. Tasks never write to the same place, so results do not depend on the schedule.
using ParallelFor =
    std::function<void(std::size_t count, const std::function<void(std::size_t)>& task)>;

/// The default: one after the other on the calling thread. A type of its own, by which `is_serial`
/// knows it in every file of a program, whatever that is compiled for.
struct SerialFor {
  void operator()(std::size_t count, const std::function<void(std::size_t)>& task) const {
    for (std::size_t i = 0; i < count; ++i) task(i);
  }
};
inline constexpr SerialFor serial_for{};

/// Whether a hook is known to be `serial_for`: work need not be divided for it.
[[nodiscard]] bool is_serial(const ParallelFor& parallel_for);

/// Adds up part(first, end, sum) over [0, count) in slices of `size`. Every slice starts from a
/// `Sum{}` of its own and slices are added in their order, so that the rounding is the same
/// whoever does them, one after the other or at the same time. Allocates nothing.
/// @param fewest_shared  [-] The hook is called for no fewer slices than this.
template <typename Sum, typename Part>
[[nodiscard]] Sum sum_in_slices(std::size_t count, std::size_t size, std::size_t fewest_shared,
                                const ParallelFor& parallel_for, const Part& part);

// Implementation -----------------------------------------------------------------------------------

inline bool is_serial(const ParallelFor& parallel_for) {
#if defined(__cpp_rtti)
  return parallel_for.target<SerialFor>() != nullptr;
#else
  (void)parallel_for;
  return false;
#endif
}

namespace detail {

/// Room for a T, which is there only from `make` to `destroy`; who makes it destroys it.
template <typename T>
class Room {
 public:
  Room() {}
  Room(const Room&) = delete;
  Room& operator=(const Room&) = delete;
  ~Room() {}
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
Sum sum_in_slices(std::size_t count, std::size_t size, std::size_t fewest_shared,
                  const ParallelFor& parallel_for, const Part& part) {
  const std::size_t slices = (count + size - 1) / size;
  const auto add_slice = [&](std::size_t k, Sum& sum) {
    part(k * size, std::min(count, (k + 1) * size), sum);
  };
  Sum total{};
  if (slices <= 1) {
    add_slice(0, total);
  } else if (slices < fewest_shared || is_serial(parallel_for)) {
    for (std::size_t k = 0; k < slices; ++k) {
      Sum sum{};
      add_slice(k, sum);
      total += sum;
    }
  } else {
    // As many at a time as there is room for. Who adds up a slice makes its sum: those of contacts
    // are 44 KiB in registers of 64 bytes, which one thread would write before the others start.
    std::array<detail::Room<Sum>, 32> sums;
    for (std::size_t first = 0; first < slices; first += sums.size()) {
      const std::size_t some = std::min(sums.size(), slices - first);
      const auto task = [&](std::size_t k) { add_slice(first + k, sums[k].make()); };
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
