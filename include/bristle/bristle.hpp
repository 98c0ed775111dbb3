/// @file
/// The whole library. It needs Eigen and the standard library, nothing else; the FCL backend joins
/// in where the CMake target `bristle::fcl` is linked.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/collision/filter.hpp>
#include <bristle/core/config.hpp>
#include <bristle/core/error.hpp>
#include <bristle/core/parallel.hpp>
#include <bristle/core/slot_map.hpp>
#include <bristle/core/version.hpp>
#include <bristle/dynamics/body.hpp>
#include <bristle/dynamics/constraint.hpp>
#include <bristle/dynamics/direct_solver.hpp>
#include <bristle/dynamics/integrator.hpp>
#include <bristle/dynamics/joint.hpp>
#include <bristle/dynamics/material.hpp>
#include <bristle/dynamics/sequential_solver.hpp>
#include <bristle/dynamics/soft_block.hpp>
#include <bristle/dynamics/solver_types.hpp>
#include <bristle/geometry/aabb.hpp>
#include <bristle/geometry/aabb_tree.hpp>
#include <bristle/geometry/contact_manifold.hpp>
#include <bristle/geometry/convex_hull.hpp>
#include <bristle/geometry/mesh_validation.hpp>
#include <bristle/geometry/ray.hpp>
#include <bristle/geometry/ray_shapes.hpp>
#include <bristle/geometry/shape_backend.hpp>
#include <bristle/geometry/shape_properties.hpp>
#include <bristle/geometry/shapes.hpp>
#include <bristle/geometry/triangle_mesh.hpp>
#include <bristle/math/cholesky.hpp>
#include <bristle/math/mass_properties.hpp>
#include <bristle/math/rotation.hpp>
#include <bristle/math/spatial.hpp>
#include <bristle/math/transform.hpp>
#include <bristle/math/types.hpp>
#include <bristle/sensors/ambf_law.hpp>
#include <bristle/sensors/law.hpp>
#include <bristle/sensors/patch.hpp>
#include <bristle/sensors/patch_block.hpp>
#include <bristle/sensors/patch_contacts.hpp>
#include <bristle/sensors/placement.hpp>
#include <bristle/sensors/reading.hpp>
#include <bristle/sensors/sensor_layout.hpp>
#include <bristle/sensors/sensor_parameters.hpp>

#if defined(BRISTLE_WITH_FCL)
#include <bristle/geometry/fcl_contact_normal.hpp>
#include <bristle/geometry/fcl_mesh_tree.hpp>
#include <bristle/geometry/fcl_shapes.hpp>
#endif
