// The library of a program that has the single header and no CMake: this is all of the file.
// SPDX-License-Identifier: BSD-3-Clause
#define BRISTLE_INSTANTIATE double
#define BRISTLE_WITH_FILES 1
#include <bristle/bristle.hpp>
