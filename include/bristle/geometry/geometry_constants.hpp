/// @file
/// Constants of the geometry that no formula gives.
///
/// `tests/constants` runs scenes with each at half and at twice its value.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <cstddef>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail::chosen {

// Boxes and clipped features.

/// [1] Part of its gap by which another axis of two boxes must be better to become the normal. A
/// smaller value lets resting boxes change their normal. A greater one keeps a worse normal.
inline constexpr double box_axis_preference = 0.05;

/// [1] Places on a face of a box that differ by less than this count as one, by the size of the
/// boxes. A smaller value lets corners in sliding heaps come and go, as at 1e-8. A greater one
/// moves contacts. Decision 0058: pushed heaps took 0.34 to 1 of the time with it.
inline constexpr double box_corner_merging = 1e-5;

/// [1] Sine, of 3 degrees, within which an edge is across a direction and two edges are parallel. A
/// smaller value makes points of edges, as iterative normals are off by that much. A greater one
/// makes edges of points.
inline constexpr double edge_across_sine = 0.05;

/// [1] 1 minus the cosine, of 3 degrees, within which a face is aligned with the normal. A smaller
/// value makes points of faces. A greater one clips faces that stand at an angle.
inline constexpr double aligned_face_versine = 0.0014;

/// [1] Cosine between the normal and a face, below which an edge replaces the face. A smaller value
/// clips nearly upright faces. A greater one drops faces that meet an aligned one.
inline constexpr double facing_face_cosine = 0.2;

// Search for the direction of least overlap, and distances.

/// [1] The distance of curved cores is sought this many times finer than `Tolerance::equal`. A
/// smaller value leaves a rough normal. A greater one costs supports.
inline constexpr double curved_distance_refinement = 100.0;

/// [1] Overlapping solids are pushed apart by the size of the smaller one over this, in units of
/// the larger. A smaller value pushes past the valley. A greater one leaves a distance that is
/// rough.
inline constexpr double overlap_push_divisor = 8.0;

/// [1] Gains of a direction count for curved solids from `Tolerance::equal` over this on. A smaller
/// value ends sooner, with more left to `polish`. A greater one costs pushes.
inline constexpr double curved_gain_refinement = 16.0;

/// [1] Part of the overlap of curved solids within which the polytope ends. A smaller value costs
/// faces. A greater one may take the other of two valleys (decision 0010: a fiftieth).
inline constexpr double curved_overlap_slack = 0.02;

/// [1] Pushes whose steps shrink by a smaller part than this count as not shrinking. A smaller
/// value extrapolates very far. A greater one uses `stalled_push_leap` where the limit is known.
inline constexpr double stalled_push_shrinkage = 0.05;

/// [1] Steps that a push leaps ahead where steps do not shrink. Steps that shrink by a twentieth
/// have 19 left. A smaller value costs pushes. A greater one leaps past the valley.
inline constexpr double stalled_push_leap = 20.0;

/// [rad] First step of the compass search. A smaller value gets around the sphere in more rounds. A
/// greater one skips valleys.
inline constexpr double compass_first_step = 0.25;

/// [-] Most rounds of a step of the compass search. Half the sphere takes 13 first steps. A smaller
/// value ends short of the valley. A greater one only raises the bound of the cost.
inline constexpr int compass_rounds = 16;

/// [rad] Half the difference by which Newton's method takes derivatives. A smaller value loses
/// digits. A greater one measures the curvature of a wider patch.
inline constexpr double newton_difference = 0.0001220703125;

/// [rad] Longest step of Newton's method. A smaller value leaves rough normals. A greater one tries
/// directions that are no better. Only better ones are kept.
inline constexpr double newton_longest_step = 0.125;

/// [-] Most steps of Newton's method. A smaller value leaves rough normals. The error is squared in
/// each step, so a greater one gains nothing.
inline constexpr int newton_steps = 3;

/// [1] Error of the gap of polyhedra, below which a gain is none. A smaller value lets round-off
/// choose between equal directions. A greater one keeps worse normals. Decision 0058: pressed
/// blocks at rest take no factorisation.
inline constexpr double polyhedral_gap_error = 1e-11;

/// [-] Most pushes of a search. A smaller value leaves more pairs to the compass search. A greater
/// one raises the bound of the cost.
inline constexpr int overlap_pushes = 24;

/// [1] Distances of curved cores whose error is within this many `Tolerance::equal` are right. A
/// smaller value costs pushes. A greater one ends with a rough normal.
inline constexpr double curved_distance_error = 64.0;

/// [-] Most supports of one distance by GJK. A smaller value ends distances of round solids early.
/// A greater one raises the bound of the cost.
inline constexpr int gjk_supports = 64;

/// [-] Most projections in turn for a pair of nearest points. A smaller value leaves a point of the
/// gap that is off. A greater one raises the bound of the cost. Faces and corners take one or two.
inline constexpr int gap_projections = 32;

/// [-] Most distances of a sweep of one solid. A smaller value ends the sweep before the touch. A
/// greater one raises the bound of the cost. Faces and corners take one or two.
inline constexpr int sweep_distances = 64;

/// [-] Most steps of conservative advancement. A smaller value fits the plane of an impact less
/// well. A greater one costs queries of what grazes.
inline constexpr int impact_advancements = 8;

/// [-] Most iterations of libccd's GJK. A smaller value ends distances of round solids early. A
/// greater one raises the bound of the cost.
inline constexpr std::uint32_t ccd_iterations = 128;

/// [1] Gain of a step of libccd's GJK that ends it, in round-offs. A smaller value brings
/// degenerate simplices and worse results. A greater one brings rough distances of curved solids.
inline constexpr double ccd_gain = 1024.0;

// Surfaces of meshes.

/// [1] 1 minus the cosine of 0.01 degrees, within which directions count as equal. A smaller value
/// takes the error of GJK for an edge. A greater one joins faces that are meant to be apart.
inline constexpr double same_direction_versine = 1.5e-8;

/// [1] Sine of the same angle, for directions across an edge. A smaller value takes the error of
/// GJK for an edge. A greater one joins faces that are meant to be apart.
inline constexpr double same_direction_sine = 1.7e-4;

/// [1] 1 minus the cosine, of 25 degrees, within which surfaces face each other that have passed
/// through each other. A smaller value misses some. A greater one takes surfaces that cut each
/// other anyway.
inline constexpr double opposing_plates_versine = 0.1;

/// [1] How far aside a passed plate may lie, by the depth. It is the sine of the angle above,
/// 0.436, rounded up. A smaller value misses plates. A greater one costs tests of more.
inline constexpr double passed_plate_spread = 0.44;

// Rays at meshes.

/// [1] Area, by that of the ball about a shape, that a ray must pass to be tested against it. A
/// value near 1 misses hits by round-off. A greater one saves less work.
inline constexpr double ball_early_out_area = 2.0;

/// [1] Uncertainty of a crossing, in round-offs of the origin, up to which it stays where it is. A
/// smaller value moves more crossings into their triangle's box. A greater one leaves crossings of
/// triangles seen edge-on outside.
inline constexpr double trusted_crossing_error = 4.0;

/// [1] Uncertainty of a crossing at the start of a ray, in round-offs of the triangle's distance,
/// up to which the start is on the surface. A smaller value asks for the inside instead. A greater
/// one hits surfaces that are near.
inline constexpr double start_crossing_error = 64.0;

/// [-] Most rays that decide on the inside of a mesh before its winding number does. A smaller
/// value costs winding numbers more often. A greater one casts more rays at points that are never
/// decided. Hardly any ray meets an edge.
inline constexpr std::size_t inside_test_rays = 8;

/// [1] Cosine between a node's rays and its axis, above which it is narrow. A smaller value makes
/// boxes of rays that lean. A greater one casts more rays alone.
inline constexpr double narrow_node_cosine = 0.5;

/// [1] Longest extent of the ends of rays, by that of their starts, from which on they are a fan. A
/// smaller value divides convex pads by their ends, a greater one fans of a wide ring by starts.
inline constexpr double fan_spread = 2;

/// [1] A node's frame serves its children where the square of their rays' drift, times this, is at
/// most the area of a leaf. Log 0022: rays run aside by less than a quarter of the width. A smaller
/// value makes boxes of leaning rays thick. A greater one turns triangles more often.
inline constexpr double shared_frame_drift = 16.0;

/// [-] Triangles of a leaf of a mesh's tree, about half of its 16. It tells whether a list of
/// leaves can hold those of a node. A smaller value searches fewer lists. A greater one searches in
/// vain.
inline constexpr std::size_t leaf_triangles = 8;

/// [-] Leaves up to which a list is not shortened for the children. A smaller value copies short
/// lists. A greater one tests long ones in each child. Log 0022: four lists are enough, and only
/// for long ones.
inline constexpr std::size_t short_leaf_list = 24;

/// [-] Most leaves of a node that is cast as a whole. A smaller value descends to smaller nodes. A
/// greater one turns triangles in vain. Log 0022: 96 gains nothing more. With 24, and 16 triangles,
/// rays took 4 to 24 % more.
inline constexpr std::size_t whole_node_leaves = 48;

/// [1] Triangles for each ray, above which rays are cast alone. Log 0022: 10. A smaller value casts
/// rays alone that share triangles. A greater one gathers triangles that no ray shares.
inline constexpr double sparse_ray_triangles = 10.0;

/// [-] Triangles across a box, up to which a divided node is cast as a whole. A smaller value
/// descends to smaller nodes. A greater one turns triangles in vain. Log 0022: 120 gains nothing
/// more. With 16, and 24 leaves, rays took 4 to 24 % more.
inline constexpr double whole_node_triangles = 64.0;

/// [-] Fewest rays of a node for which a search of their common side pays. It is one more than a
/// leaf has. A smaller value searches for few rays. A greater one asks more rays alone.
inline constexpr std::size_t common_side_rays = 65;

/// [-] Leaves for each 64 rays, up to which a divided node tests their triangles first. A smaller
/// value descends where nothing is met. A greater one tests triangles in vain.
inline constexpr std::size_t empty_test_leaves = 2;

/// [-] Layers of triangles that a packet's box may have in sight: twice the two of a solid. A
/// smaller value overflows the list of triangles. A greater one casts rays alone that share
/// triangles.
inline constexpr double layers_in_sight = 4.0;

// Cache of triangles near rays that are cast alone. Log 0029 has the times.

/// [1] Credit that a search of a ray's triangles costs. A smaller value searches where motion is
/// fast. A greater one searches less where it is slow.
inline constexpr int cache_search_price = 80;

/// [1] Credit that a ray gains where its triangles serve again. A smaller value searches less where
/// motion is slow. A greater one searches where it is fast.
inline constexpr int cache_reuse_gain = 32;

/// [-] Queries that traverse the tree after searches did not pay. A smaller value pays for searches
/// in fast motion. A greater one notices slow motion later.
inline constexpr int cache_pause_queries = 20;

/// [-] Queries of another mesh after which a cache changes its mesh. A smaller value throws away
/// caches that still serve. A greater one leaves the present mesh without one.
inline constexpr int cache_refused_queries = 16;

/// [1] Margin of the cache, by the root of the mean area of a triangle. A smaller value searches
/// more often. A greater one finds more triangles than fit: wider by half, all gain is lost.
inline constexpr double cache_margin = 0.7;

/// [1] Part of the margin by which a search looks ahead along the motion. A smaller value searches
/// more often. Three quarters save four searches in ten. A greater one leaves the ray behind.
inline constexpr double cache_lead = 0.75;

/// [1] Motion, by the margin, above which a search does not look ahead. A smaller value
/// extrapolates slow motion less. A greater one extrapolates jumps.
inline constexpr double cache_longest_motion = 2.0;

/// [1] Round-offs of the coordinates that the margin must cover. A smaller value may miss a
/// crossing. A greater one leaves less reserve.
inline constexpr double cache_margin_error = 16.0;

/// [1] Part of the margin that round-off may take before the cache is not used. A smaller value
/// disables the cache at a finer mesh. A greater one uses caches with little reserve.
inline constexpr double cache_margin_loss = 0.2;

/// [-] Credit of searches for each ray that is the most. A smaller value pauses sooner. A greater
/// one pays for more searches in fast motion.
inline constexpr int cache_most_searches = 2;

/// [1] Parts of the rays, of which fewer than one served in the last query, makes it a poor one. A
/// smaller value pauses sooner. A greater one later.
inline constexpr std::size_t cache_poor_divisor = 8;

/// [-] Poor queries in a row after which searches pause. Decision 0029: two. A smaller value pauses
/// in slow motion, too. A greater one pays for more searches in fast motion.
inline constexpr int cache_poor_queries = 2;

/// [1] Parts of the full credit, of which one is left after a pause. A smaller value searches
/// around more rays then. A greater one notices slow motion less surely.
inline constexpr int cache_retry_divisor = 8;

// Hulls and meshes of shapes.

/// [-] Cells of the grid of 2^30 within which points of a hull count as equal. A smaller value
/// makes faces of rounding. A greater one leaves out corners.
inline constexpr double hull_resolution_cells = 8.0;

/// [1] Least height of the first simplex of a hull, in resolutions. A smaller value puts both of
/// its sides into the slab of one face. A greater one refuses thin hulls.
inline constexpr double hull_simplex_height = 16.0;

/// [1] Distance within which points of a mesh that are computed twice are one, in round-offs of its
/// size. A smaller value leaves seams open. A greater one joins corners of fine meshes.
inline constexpr double weld_distance = 16.0;

}  // namespace bristle::inline BRISTLE_ABI::detail::chosen
