// The default hook is known by code that was compiled for other registers, as kernels of the
// compiled library are. If it is not, these divide the rays of large patches among threads that are
// not there.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/core/parallel.hpp>

#include <cstdio>

bool is_known_elsewhere(const bristle::ParallelFor& hook);

int main() {
  const bristle::ParallelFor serial = bristle::serial_for;
  const bristle::ParallelFor own = [](std::size_t count,
                                      const std::function<void(std::size_t)>& task) {
    for (std::size_t i = count; i-- > 0;) task(i);
  };
  const bool is_right = bristle::is_serial(serial) && is_known_elsewhere(serial) &&
                        !bristle::is_serial(own) && !is_known_elsewhere(own);
  std::puts(is_right ? "known" : "not known");
  return is_right ? 0 : 1;
}
