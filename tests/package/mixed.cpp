// Header-only, and calls a function that a file for the compiled library defines.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/dynamics/bodies/body.hpp>

bool moves(const bristle::Body<double>& body);

int main() { return moves(bristle::Body<double>{}) ? 1 : 0; }
