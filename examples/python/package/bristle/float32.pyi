# Made of __init__.pyi: tests/python/stubs.py --update
# SPDX-License-Identifier: BSD-3-Clause
from collections.abc import Sequence
from typing import Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import (
    BodyId,
    ContactEvent,
    Integration,
    JointId,
    JointKind,
    Motion,
    MotorMode,
    NormalDirection,
    PatchId,
    Scene,
    ShapeId,
    SlipReset,
    TouchEvent,
)

class Sphere:
    def __init__(self, radius: float) -> None: ...

class Box:
    def __init__(self, half_extents: ArrayLike) -> None: ...

class Capsule:
    def __init__(self, radius: float, half_length: float) -> None: ...

class Cylinder:
    def __init__(self, radius: float, half_length: float) -> None: ...

class Cone:
    def __init__(self, radius: float, half_length: float) -> None: ...

class Ellipsoid:
    def __init__(self, radii: ArrayLike) -> None: ...

class ConvexHull:
    def __init__(self, points: ArrayLike) -> None: ...

class HalfSpace:
    def __init__(self, normal: ArrayLike = ..., offset: float = ...) -> None: ...

class TriangleMesh:
    def __init__(self, vertices: ArrayLike, triangles: ArrayLike) -> None: ...
    @staticmethod
    def load(path: str) -> TriangleMesh: ...
    @property
    def vertices(self) -> NDArray[np.float32]: ...
    @property
    def triangles(self) -> NDArray[np.uint32]: ...

def height_field_mesh(size: ArrayLike, heights: ArrayLike) -> TriangleMesh: ...
def extruded_mesh(surface: TriangleMesh, offset: ArrayLike) -> TriangleMesh: ...

_Shape = Union[
    Sphere, Box, Capsule, Cylinder, Cone, Ellipsoid, ConvexHull, HalfSpace, TriangleMesh
]

class SensorParameters:
    normal_stiffness: float
    normal_damping: float
    static_friction: float
    sliding_friction: float
    breakaway_distance: float
    def __init__(
        self,
        normal_stiffness: float,
        normal_damping: float = ...,
        static_friction: float = ...,
        sliding_friction: float = ...,
        breakaway_distance: float = ...,
    ) -> None: ...

class SensorLayout:
    def __init__(self) -> None: ...
    def __len__(self) -> int: ...
    def add(self, start: ArrayLike, direction: ArrayLike, length: float) -> None: ...

def sensor_grid(
    center: ArrayLike,
    side_u: ArrayLike,
    side_v: ArrayLike,
    count_u: int,
    count_v: int,
    depth: float = ...,
    range: float = ...,
) -> SensorLayout: ...

class Tuning:
    def parameters(self, sensors: SensorLayout) -> SensorParameters: ...

def tuned_for(
    *,
    friction: float = ...,
    creep: float = ...,
    load: float = ...,
    mass: float = ...,
    press: float = ...,
    radius: float = ...,
    normal_damping_ratio: float = ...,
    bristle_damping_ratio: float = ...,
) -> Tuning: ...

class Reading:
    @property
    def depth(self) -> NDArray[np.float32]: ...
    @property
    def normal_force(self) -> NDArray[np.float32]: ...
    @property
    def shear_1(self) -> NDArray[np.float32]: ...
    @property
    def shear_2(self) -> NDArray[np.float32]: ...
    @property
    def point(self) -> NDArray[np.float32]: ...
    @property
    def touches(self) -> NDArray[np.bool_]: ...
    @property
    def slips(self) -> NDArray[np.bool_]: ...
    @property
    def force(self) -> NDArray[np.float32]: ...
    @property
    def torque(self) -> NDArray[np.float32]: ...
    @property
    def total_normal(self) -> float: ...
    @property
    def total_shear(self) -> float: ...
    @property
    def touching(self) -> int: ...
    @property
    def slipping(self) -> int: ...
    @property
    def bottomed_out(self) -> int: ...

class WorldHits:
    @property
    def is_hit(self) -> NDArray[np.bool_]: ...
    @property
    def distance(self) -> NDArray[np.float32]: ...
    @property
    def point(self) -> NDArray[np.float32]: ...
    @property
    def normal(self) -> NDArray[np.float32]: ...
    @property
    def body(self) -> NDArray[np.object_]: ...

class World:
    def __init__(
        self,
        *,
        gravity: ArrayLike = ...,
        time_step: float = ...,
        keeps_contact_events: bool = ...,
    ) -> None: ...
    def __copy__(self) -> World: ...
    def copy(self) -> World: ...
    def add_body(
        self,
        *,
        motion: Motion = ...,
        shape: _Shape | None = ...,
        mass: float | None = ...,
        position: ArrayLike = ...,
        orientation: ArrayLike = ...,
        velocity: ArrayLike = ...,
        angular_velocity: ArrayLike = ...,
        friction: float = ...,
        restitution: float = ...,
        rolling_friction: float = ...,
        surface_velocity: ArrayLike = ...,
        linear_damping: float = ...,
        angular_damping: float = ...,
        gravity_scale: float = ...,
        shapes: Sequence[tuple[_Shape, ArrayLike, ArrayLike]] = ...,
        is_trigger: bool = ...,
    ) -> BodyId: ...
    def remove_body(self, body: BodyId) -> None: ...
    def add_joint(
        self,
        kind: JointKind,
        body_a: BodyId | None,
        body_b: BodyId | None,
        *,
        anchor_a: ArrayLike = ...,
        rotation_a: ArrayLike = ...,
        anchor_b: ArrayLike = ...,
        rotation_b: ArrayLike = ...,
        lower: float = ...,
        upper: float = ...,
        mode: MotorMode = ...,
        target: float = ...,
        max_force: float = ...,
        max_speed: float = ...,
        stiffness: float = ...,
        damping: float = ...,
        swing_limit: float = ...,
        bushing_stiffness: ArrayLike = ...,
        bushing_damping: ArrayLike = ...,
    ) -> JointId: ...
    def set_motor(
        self,
        joint: JointId,
        *,
        mode: MotorMode,
        target: float = ...,
        max_force: float = ...,
        max_speed: float = ...,
        stiffness: float = ...,
        damping: float = ...,
    ) -> None: ...
    def set_limits(self, joint: JointId, lower: float = ..., upper: float = ...) -> None: ...
    def set_spring(
        self,
        joint: JointId,
        *,
        stiffness: float = ...,
        damping: float = ...,
        rest: float = ...,
    ) -> None: ...
    def joint_state(self, joint: JointId) -> tuple[float, float]: ...
    def add_patch(
        self,
        body: BodyId,
        sensors: SensorLayout,
        parameters: SensorParameters,
        *,
        integration: Integration = ...,
        reset: SlipReset = ...,
        normal: NormalDirection = ...,
        cast_every: int = ...,
    ) -> PatchId: ...
    def set_parameters(self, patch: PatchId, parameters: SensorParameters) -> None: ...
    def set_mass(self, body: BodyId, mass: float) -> None: ...
    def set_damping(self, body: BodyId, linear: float, angular: float = ...) -> None: ...
    def set_gravity_scale(self, body: BodyId, scale: float) -> None: ...
    def set_material(
        self,
        body: BodyId,
        friction: float,
        restitution: float = ...,
        rolling_friction: float = ...,
        surface_velocity: ArrayLike = ...,
    ) -> None: ...
    def set_gravity(self, gravity: ArrayLike) -> None: ...
    def set_time_step(self, time_step: float) -> None: ...
    def set_pose(
        self, body: BodyId, position: ArrayLike, orientation: ArrayLike = ...
    ) -> None: ...
    def set_velocity(
        self, body: BodyId, linear: ArrayLike, angular: ArrayLike = ...
    ) -> None: ...
    def move_to(
        self, body: BodyId, position: ArrayLike, orientation: ArrayLike = ...
    ) -> None: ...
    def apply_force(self, body: BodyId, force: ArrayLike, point: ArrayLike) -> None: ...
    def apply_wrench(self, body: BodyId, force: ArrayLike, torque: ArrayLike) -> None: ...
    def apply_impulse(self, body: BodyId, impulse: ArrayLike, point: ArrayLike) -> None: ...
    def contains(self, handle: BodyId | JointId | PatchId | ShapeId) -> bool: ...
    def position(self, body: BodyId) -> NDArray[np.float32]: ...
    def orientation(self, body: BodyId) -> NDArray[np.float32]: ...
    def velocity(self, body: BodyId) -> tuple[NDArray[np.float32], NDArray[np.float32]]: ...
    def reading(self, patch: PatchId) -> Reading: ...
    def taxel_points(self, patch: PatchId) -> NDArray[np.float32]: ...
    def patch_warnings(self, patch: PatchId) -> list[str]: ...
    def step(self, steps: int = ...) -> None: ...
    def snapshot(self) -> bytes: ...
    def restore(self, bytes: bytes) -> None: ...
    def state_hash(self) -> int: ...
    def cast_rays(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        max_distance: ArrayLike = ...,
        *,
        excluded: Sequence[BodyId] = ...,
        meets_triggers: bool = ...,
    ) -> WorldHits: ...
    def keep_touch_events(self, on: bool = ...) -> None: ...
    def touch_events(self) -> list[TouchEvent]: ...
    def clear_touch_events(self) -> None: ...
    def contact_events(self) -> list[ContactEvent]: ...
    def clear_contact_events(self) -> None: ...
    @property
    def time_step(self) -> float: ...

class WorldBatch:
    def __init__(self, origin: World, count: int, threads: int = ...) -> None: ...
    def __len__(self) -> int: ...
    def __getitem__(self, number: int) -> World: ...
    def step(self, steps: int = ...) -> None: ...
    def reset(self, mask: ArrayLike | None = ...) -> None: ...
    @property
    def failed(self) -> NDArray[np.bool_]: ...
    def set_mass(
        self, body: BodyId, masses: ArrayLike, mask: ArrayLike | None = ...
    ) -> None: ...
    def set_material(
        self,
        body: BodyId,
        friction: ArrayLike,
        restitution: ArrayLike = ...,
        mask: ArrayLike | None = ...,
        rolling_friction: ArrayLike = ...,
        surface_velocity: ArrayLike = ...,
    ) -> None: ...
    def set_damping(
        self,
        body: BodyId,
        linear: ArrayLike,
        angular: ArrayLike = ...,
        mask: ArrayLike | None = ...,
    ) -> None: ...
    def set_gravity_scale(
        self, body: BodyId, scales: ArrayLike, mask: ArrayLike | None = ...
    ) -> None: ...
    def set_parameters(
        self,
        patch: PatchId,
        parameters: SensorParameters | Sequence[SensorParameters],
        mask: ArrayLike | None = ...,
    ) -> None: ...
    def set_motor(
        self,
        joint: JointId,
        *,
        mode: MotorMode,
        target: ArrayLike = ...,
        max_force: ArrayLike = ...,
        max_speed: ArrayLike = ...,
        stiffness: ArrayLike = ...,
        damping: ArrayLike = ...,
        mask: ArrayLike | None = ...,
    ) -> None: ...
    def set_pose(
        self,
        body: BodyId,
        positions: ArrayLike,
        orientations: ArrayLike = ...,
        mask: ArrayLike | None = ...,
    ) -> None: ...
    def move_to(
        self,
        body: BodyId,
        positions: ArrayLike,
        orientations: ArrayLike = ...,
        mask: ArrayLike | None = ...,
    ) -> None: ...
    def set_velocity(
        self,
        body: BodyId,
        linear: ArrayLike,
        angular: ArrayLike = ...,
        mask: ArrayLike | None = ...,
    ) -> None: ...
    def apply_force(
        self,
        body: BodyId,
        forces: ArrayLike,
        points: ArrayLike,
        mask: ArrayLike | None = ...,
    ) -> None: ...
    def apply_impulse(
        self,
        body: BodyId,
        impulses: ArrayLike,
        points: ArrayLike,
        mask: ArrayLike | None = ...,
    ) -> None: ...
    def bodies(
        self, bodies: Sequence[BodyId], out: NDArray[np.float32] | None = ...
    ) -> NDArray[np.float32]: ...
    def joints(
        self, joints: Sequence[JointId], out: NDArray[np.float32] | None = ...
    ) -> NDArray[np.float32]: ...
    def taxels(
        self, patches: Sequence[PatchId], out: NDArray[np.float32] | None = ...
    ) -> NDArray[np.float32]: ...
    def points(
        self, patches: Sequence[PatchId], out: NDArray[np.float32] | None = ...
    ) -> NDArray[np.float32]: ...
    def touching(
        self, patches: Sequence[PatchId], out: NDArray[np.uint32] | None = ...
    ) -> NDArray[np.uint32]: ...

class Recorder:
    def __init__(self, rate: float = ...) -> None: ...
    def add_body(
        self,
        world: World,
        body: BodyId,
        shape: _Shape,
        name: str,
        plane_size: float = ...,
    ) -> None: ...
    def add_patch(self, world: World, patch: PatchId, name: str) -> None: ...
    def observe(self, world: World) -> None: ...
    def follow(self, world: World) -> None: ...
    @property
    def times(self) -> NDArray[np.double]: ...
    def write_glb(self, path: str, longest_arrow: float = ...) -> None: ...

def add_scene(world: World, path: str, hold_joints: bool = ...) -> Scene: ...
