"""The scene of `bristle.grip`: a part on a floor between two fingers that slide on a palm."""
# SPDX-License-Identifier: BSD-3-Clause
import math

from . import MotorMode, JointKind, Motion, SlipReset, float32

PART_HALF_EDGE = 0.02  # [m]
FINGER_HALF_EXTENTS = (0.012, 0.006, 0.012)  # [m]
FINGER_START = 0.032  # [m] from the middle; pads are then 6 mm from the part.
# [m] Middle of the pads above that of the part: its upper edge is that of the pads, so that rows of
# sensors lose a part that slips down.
GRIP_ABOVE_MIDDLE = 0.010
FINGER_SPEED = 0.1  # [m/s] at which fingers close.
MAX_FORCE = 20.0  # [N] of a finger.
PAD_ROWS = 4  # Sensors along each side of a pad.
PAD_SIDE = 0.020  # [m]
TIME_STEP = 1 / 240  # [s]
CREEP = 1e-3  # [m] that a held part sags before it slips.
LIGHTEST, HEAVIEST = 0.1, 0.8  # [kg] Mass of the part.


class GripScene:
    """A world in float and what is in it.

    The part is a cube on a floor. Each finger slides along y towards the part, driven to close with
    a largest force; the palm that carries them is kinematic and moves along z.
    """

    def __init__(self):
        b = float32
        self.world = b.World(time_step=TIME_STEP)
        self.floor_shape = b.HalfSpace()
        self.floor = self.world.add_body(motion=Motion.fixed, shape=self.floor_shape)
        self.part_shape = b.Box((PART_HALF_EDGE,) * 3)
        self.part = self.world.add_body(mass=0.3, shape=self.part_shape,
                                        position=(0, 0, PART_HALF_EDGE))
        self.palm_height = PART_HALF_EDGE + GRIP_ABOVE_MIDDLE
        self.palm = self.world.add_body(motion=Motion.kinematic, position=(0, 0, self.palm_height))
        self.finger_shape = b.Box(FINGER_HALF_EXTENTS)
        half_turn = math.sqrt(0.5)
        self.fingers, self.joints, self.pads = [], [], []
        for side in (-1, 1):
            finger = self.world.add_body(mass=0.1, shape=self.finger_shape,
                                         position=(0, side * FINGER_START, self.palm_height))
            # The x axis of the joint points from the finger to the part.
            towards_part = (0, 0, -side * half_turn, half_turn)
            self.joints.append(self.world.add_joint(
                JointKind.prismatic, self.palm, finger, anchor_a=(0, side * FINGER_START, 0),
                rotation_a=towards_part, rotation_b=towards_part))
            self.layout = b.sensor_grid(center=(0, -side * FINGER_HALF_EXTENTS[1], 0),
                                        side_u=(PAD_SIDE, 0, 0), side_v=(0, 0, side * PAD_SIDE),
                                        count_u=PAD_ROWS, count_v=PAD_ROWS)
            self.pads.append(self.world.add_patch(finger, self.layout, self.pad_parameters(0.5),
                                                  reset=SlipReset.drag))
            self.fingers.append(finger)
        # The part rests before anything starts.
        self.world.step(60)
        self.rest_height = float(self.world.position(self.part)[2])

    def pad_parameters(self, friction):
        """Constants of pads that hold `friction` [1] times what presses on them."""
        # Damped for the lightest part, and little: what slips then falls, and does not creep.
        return float32.tuned_for(friction=friction, creep=CREEP, load=MAX_FORCE, mass=LIGHTEST,
                                 press=0.5, bristle_damping_ratio=0.05).parameters(self.layout)

    def new_recorder(self, rate=60.0):
        """A recorder of all that is seen, `rate` frames a second."""
        recorder = float32.Recorder(rate)
        recorder.add_body(self.world, self.floor, self.floor_shape, "floor", plane_size=0.3)
        recorder.add_body(self.world, self.part, self.part_shape, "part")
        for name, finger, pad in zip(("left", "right"), self.fingers, self.pads):
            recorder.add_body(self.world, finger, self.finger_shape, f"{name} finger")
            recorder.add_patch(self.world, pad, f"{name} pad")
        return recorder
