// Header-only like the file that calls it, for wider registers.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/dynamics/bodies/body.hpp>

bool moves(const bristle::Body<double>& body);
bool moves(const bristle::Body<double>& body) { return body.moves(); }
