/// @file
/// Version of the library. CMake reads these three lines; nothing else repeats them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#define BRISTLE_VERSION_MAJOR 0
#define BRISTLE_VERSION_MINOR 1
#define BRISTLE_VERSION_PATCH 0
