// libFuzzer: bytes as an STL file, read, and made a hull, a solid and a skin of sensors.
// SPDX-License-Identifier: BSD-3-Clause
#include "mesh_uses.hpp"

#include <bristle/io/stl.hpp>

#include <cstddef>
#include <cstdint>
#include <string_view>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const std::string_view bytes(reinterpret_cast<const char*>(data), size);
    bristle::test::use_mesh(bristle::read_stl<double>(bytes));
  } catch (const bristle::IoError&) {
    // The one thing that bad bytes may do.
  }
  return 0;
}
