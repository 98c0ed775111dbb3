// The library itself, in double and in float.
// SPDX-License-Identifier: BSD-3-Clause
#include "benchmarks/work_precision/drivers/bristle_driver.hpp"

std::vector<bristle::work_precision::EngineFamily> bristle::work_precision::engine_families() {
  return {bristle_family<double>("bristle64"), bristle_family<float>("bristle32")};
}
