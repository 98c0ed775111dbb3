// The library of a program that has the single header and no CMake: this is all of the file.
// SPDX-License-Identifier: BSD-3-Clause
#define BRISTLE_INSTANTIATE double
#include <bristle/bristle.hpp>
