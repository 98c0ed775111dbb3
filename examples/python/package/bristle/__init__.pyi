# Types of the package. float32.pyi is made of the second half of this file:
# tests/python/stubs.py --update
# SPDX-License-Identifier: BSD-3-Clause
from collections.abc import Mapping, Sequence
from typing import Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import float32 as float32

__version__: str

class InvalidArgument(ValueError): ...
class IoError(OSError): ...

class _Handle:
    def __eq__(self, other: object) -> bool: ...
    def __hash__(self) -> int: ...

class BodyId(_Handle): ...
class JointId(_Handle): ...
class PatchId(_Handle): ...

class _Enum:
    def __init__(self, value: int) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def value(self) -> int: ...

class Motion(_Enum):
    fixed: Motion
    kinematic: Motion
    dynamic: Motion

class Integration(_Enum):
    explicit: Integration
    implicit: Integration
    automatic: Integration

class SlipReset(_Enum):
    release: SlipReset
    drag: SlipReset

class NormalDirection(_Enum):
    ray: NormalDirection
    gradient: NormalDirection

class JointKind(_Enum):
    fixed: JointKind
    revolute: JointKind
    prismatic: JointKind
    ball: JointKind

class MotorMode(_Enum):
    none: MotorMode
    velocity: MotorMode
    position: MotorMode
    spring: MotorMode

class Scene:
    @property
    def bodies(self) -> dict[str, BodyId]: ...
    @property
    def joints(self) -> dict[str, JointId]: ...
    @property
    def patches(self) -> dict[str, PatchId]: ...
    @property
    def report(self) -> str: ...

def write_plot(
    path: str,
    panels: Mapping[str, Mapping[str, tuple[ArrayLike, ArrayLike]]],
    x_label: str,
    title: str = ...,
) -> None: ...

# Once for each scalar:

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
    @staticmethod
    def load(path: str) -> TriangleMesh: ...

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
    def depth(self) -> NDArray[np.float64]: ...
    @property
    def normal_force(self) -> NDArray[np.float64]: ...
    @property
    def shear_1(self) -> NDArray[np.float64]: ...
    @property
    def shear_2(self) -> NDArray[np.float64]: ...
    @property
    def point(self) -> NDArray[np.float64]: ...
    @property
    def touches(self) -> NDArray[np.bool_]: ...
    @property
    def slips(self) -> NDArray[np.bool_]: ...
    @property
    def force(self) -> NDArray[np.float64]: ...
    @property
    def torque(self) -> NDArray[np.float64]: ...
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

class World:
    def __init__(self, *, gravity: ArrayLike = ..., time_step: float = ...) -> None: ...
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
    ) -> BodyId: ...
    def remove_body(self, body: BodyId) -> None: ...
    def add_joint(
        self,
        kind: JointKind,
        body_a: BodyId,
        body_b: BodyId,
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
    def set_material(
        self,
        body: BodyId,
        friction: float,
        restitution: float = ...,
        rolling_friction: float = ...,
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
    def position(self, body: BodyId) -> NDArray[np.float64]: ...
    def orientation(self, body: BodyId) -> NDArray[np.float64]: ...
    def velocity(self, body: BodyId) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
    def reading(self, patch: PatchId) -> Reading: ...
    def patch_warnings(self, patch: PatchId) -> list[str]: ...
    def step(self, steps: int = ...) -> None: ...
    def snapshot(self) -> bytes: ...
    def restore(self, bytes: bytes) -> None: ...
    def state_hash(self) -> int: ...
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
    def bodies(
        self, bodies: Sequence[BodyId], out: NDArray[np.float64] | None = ...
    ) -> NDArray[np.float64]: ...
    def joints(
        self, joints: Sequence[JointId], out: NDArray[np.float64] | None = ...
    ) -> NDArray[np.float64]: ...
    def taxels(
        self, patches: Sequence[PatchId], out: NDArray[np.float64] | None = ...
    ) -> NDArray[np.float64]: ...
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
