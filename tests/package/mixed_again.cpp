// For the compiled library.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/dynamics/bodies/body.hpp>

bool moves(const bristle::Body<double>& body);
bool moves(const bristle::Body<double>& body) { return body.moves(); }
