"""Tests of meshes from arrays: solids, terrain, and what is no surface."""
# SPDX-License-Identifier: BSD-3-Clause
import sys
import unittest

try:
    import numpy as np
except ImportError:
    print("skipped: no numpy")
    sys.exit(77)

import bristle
import bristle.float32 as bristle32

# A module and its rounding.
SCALARS = ((bristle, 1e-9), (bristle32, 1e-4))

# A right-angled corner of a cube of 1 m.
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def mass_of(module, mesh):
    """Mass [kg] of a mesh as a solid of water, by the push that it takes."""
    world = module.World(gravity=(0, 0, 0))
    body = world.add_body(shape=mesh)
    world.apply_impulse(body, (0, 0, 1000), world.position(body))
    return 1000 / world.velocity(body)[0][2]


class Solids(unittest.TestCase):
    def test_arrays_of_any_whole_numbers_make_a_solid(self):
        for module, error in SCALARS:
            for integers in (np.int8, np.uint32, np.int64, np.uint64):
                mesh = module.TriangleMesh(0.3 * CORNERS, FACES.astype(integers))
                self.assertAlmostEqual(mass_of(module, mesh) / (1000 * 0.3**3 / 6), 1, delta=error)
            self.assertAlmostEqual(
                mass_of(module, module.TriangleMesh(CORNERS.tolist(), FACES.tolist())) * 6e-3, 1,
                delta=error)
            # Views that are not in C order are read as what they say.
            mesh = module.TriangleMesh(np.asfortranarray(CORNERS)[::-1], 3 - FACES[:, ::1])
            np.testing.assert_array_equal(mesh.vertices, CORNERS[::-1])
            np.testing.assert_array_equal(mesh.triangles, 3 - FACES)
            self.assertEqual((mesh.vertices.dtype, mesh.triangles.dtype),
                             (np.float64 if module is bristle else np.float32, np.uint32))
            mesh.vertices[0] = 7  # a copy
            np.testing.assert_array_equal(mesh.vertices, CORNERS[::-1])

    def test_what_is_no_surface_is_named(self):
        for module, _ in SCALARS:
            bent = CORNERS.astype(float)
            bent[2, 1] = np.nan
            wrong = FACES.copy()
            wrong[1, 2] = 4
            invalid = bristle.InvalidArgument
            for vertices, triangles, error, words in (
                    (CORNERS[:, :2], FACES, invalid,
                     r"vertices.shape = \(4, 2\): must be \(vertices, 3\)"),
                    (CORNERS[0], FACES, invalid, r"vertices.shape = \(3,\)"),
                    ([[0, 0, 0], [1, 0]], FACES, invalid, "vertices = .*equally long"),
                    (CORNERS.astype(str), FACES, TypeError, "vertices: dtype <U.*real numbers"),
                    (CORNERS + 1j, FACES, TypeError, "complex128"),
                    (bent, FACES, invalid, r"vertices\[2\] = .*must be finite"),
                    (CORNERS, FACES[0], invalid, r"triangles.shape = \(3,\)"),
                    (CORNERS, FACES[:, :2], invalid, r"must be \(triangles, 3\)"),
                    (CORNERS, [[0, 1, 2], [0, 1]], invalid, "triangles = .*equally long"),
                    (CORNERS, FACES.astype(float), TypeError,
                     "triangles: dtype float64: must be whole numbers"),
                    (CORNERS, FACES > 1, TypeError, "dtype bool"),
                    (CORNERS, FACES[:0], invalid, "at least one triangle"),
                    (CORNERS, wrong, invalid, r"triangles\[1, 2\] = 4: must be from 0 to 3"),
                    (CORNERS, FACES - 1, invalid, r"triangles\[0, 0\] = -1"),
                    # Cut to 32 bits these are 0 and 1.
                    (CORNERS, FACES + 2**32, invalid, "= 4294967296"),
                    (CORNERS, FACES.astype(np.uint64) + 2**63, invalid, "must be from 0 to 3")):
                with self.assertRaisesRegex(error, words):
                    module.TriangleMesh(vertices, triangles)

    def test_an_open_surface_is_no_shape_and_the_world_is_as_before(self):
        for module, _ in SCALARS:
            world = module.World()
            before = world.state_hash()
            surface = module.TriangleMesh(CORNERS, FACES[:3])
            with self.assertRaisesRegex(bristle.InvalidArgument, "TriangleMesh"):
                world.add_body(mass=1, shape=surface)
            self.assertEqual(world.state_hash(), before)


class Terrain(unittest.TestCase):
    def test_heights_are_rows_along_x(self):
        for module, error in SCALARS:
            x, y = np.linspace(-1.5, 1.5, 7), np.linspace(-1, 1, 5)
            heights = 0.2 * x[None, :] - 0.3 * y[:, None] + 0.05
            surface = module.height_field_mesh((3, 2), heights)
            np.testing.assert_allclose(surface.vertices[:, 2], heights.ravel(), rtol=error)
            np.testing.assert_allclose(surface.vertices[:7, 0], x, atol=error)
            world = module.World()
            ground = world.add_body(motion=bristle.Motion.fixed,
                                    shape=module.extruded_mesh(surface, (0, 0, -0.5)))
            places = np.random.default_rng(3).uniform((-1.5, -1), (1.5, 1), (200, 2))
            starts = np.column_stack([places, np.full(200, 2)])
            hits = world.cast_rays(starts, (0, 0, -1))
            self.assertTrue((hits.body == ground).all())
            np.testing.assert_allclose(hits.point[:, 2],
                                       places @ (0.2, -0.3) + 0.05, atol=10 * error)
            up = np.array([-0.2, 0.3, 1]) / np.linalg.norm([0.2, 0.3, 1])
            np.testing.assert_allclose(hits.normal, np.tile(up, (200, 1)), atol=10 * error)

    def test_ground_has_the_volume_of_its_area_times_its_depth(self):
        for module, error in SCALARS:
            heights = np.random.default_rng(5).uniform(0, 0.1, (4, 6))
            ground = module.extruded_mesh(module.height_field_mesh((0.5, 0.3), heights),
                                          (0, 0, -0.2))
            self.assertAlmostEqual(mass_of(module, ground) / (1000 * 0.5 * 0.3 * 0.2), 1,
                                   delta=error)

    def test_a_ball_rests_in_a_valley(self):
        for module, error in SCALARS:
            slope, radius = 0.5, 0.1
            x = np.linspace(-1, 1, 41)
            heights = np.tile(slope * np.abs(x), (11, 1))
            world = module.World(time_step=1e-3)
            world.add_body(motion=bristle.Motion.fixed, shape=module.extruded_mesh(
                module.height_field_mesh((2, 0.5), heights), (0, 0, -0.3)))
            # It touches both sides, whose normals lean by the angle of the slope.
            height = radius * np.sqrt(1 + slope**2)
            ball = world.add_body(mass=1, shape=module.Sphere(radius), position=(0, 0, height + 0.01))
            world.step(2000)
            np.testing.assert_allclose(world.position(ball), [0, 0, height],
                                       atol=max(1e-4, 10 * error))
            self.assertLess(np.abs(world.velocity(ball)[0]).max(), 1e-3)

    def test_what_is_no_terrain_is_named(self):
        for module, _ in SCALARS:
            flat = np.zeros((3, 4))
            holed = flat.copy()
            holed[1, 2] = np.inf
            surface = module.height_field_mesh((1, 1), flat)
            invalid = bristle.InvalidArgument
            for call, error, words in (
                    (lambda: module.height_field_mesh((1, 1), flat[0]), invalid,
                     r"heights.shape = \(4,\)"),
                    (lambda: module.height_field_mesh((1, 1), flat[:1]), invalid, "two each at least"),
                    (lambda: module.height_field_mesh((1, 1), flat[:0]), invalid,
                     r"heights.shape = \(0, 4\)"),
                    (lambda: module.height_field_mesh((1, 1), holed), invalid, r"heights\[6\] = inf"),
                    (lambda: module.height_field_mesh((1, 1), [[0, 1], [0]]), invalid,
                     "equally long"),
                    (lambda: module.height_field_mesh((1, 1), flat.astype(str)), TypeError,
                     "heights: dtype"),
                    (lambda: module.height_field_mesh((0, 1), flat), invalid, r"size\[0\]"),
                    (lambda: module.height_field_mesh((1,), flat), TypeError, "height_field_mesh"),
                    (lambda: module.extruded_mesh(surface, (0, 0, 0)), invalid, "must not be 0"),
                    (lambda: module.extruded_mesh(surface, (0, 0, 1)), invalid,
                     "must face against the offset"),
                    (lambda: module.extruded_mesh(surface, (0, 0, np.nan)), invalid, "offset"),
                    (lambda: module.extruded_mesh(module.Sphere(1), (0, 0, -1)), TypeError,
                     "extruded_mesh")):
                with self.assertRaisesRegex(error, words):
                    call()


if __name__ == "__main__":
    unittest.main()
