// The tracks of a recording that glTF cannot animate. include/bristle/io/glb_extras.hpp says how
// they are kept.
// SPDX-License-Identifier: BSD-3-Clause

export const stateNames = ['free', 'stuck', 'slipping'];
export const slipping = 2;

/** The last of ascending numbers that is not above x, at least 0; `begin` and `end` bound them. */
function lastNotAbove(numbers, x, begin, end) {
  while (end - begin > 1) {
    const middle = (begin + end) >> 1;
    if (numbers[middle] <= x) begin = middle;
    else end = middle;
  }
  return begin;
}

/** The sensors of a patch, at one frame at a time. */
class PatchTrack {
  #first;
  #frame;
  #force;
  #depth;
  #state;
  #rows;

  constructor(glb, json) {
    this.name = json.name;
    this.node = json.node;
    this.newton = json.newton;
    this.ends = glb.numbers(json.ends);
    this.directions = glb.numbers(json.directions);
    this.count = this.ends.length / 3;
    this.#first = glb.numbers(json.first);
    this.#frame = glb.numbers(json.frame);
    this.#force = glb.numbers(json.force);
    this.#depth = glb.numbers(json.depth);
    this.#state = glb.numbers(json.state);
    this.#rows = new Int32Array(this.count);
    this.largest = 0;
    for (let row = 0; row < this.#frame.length; ++row) this.largest = Math.max(this.largest, this.#size(row));
    this.moveTo(0);
  }
  #size(row) {
    return this.newton * Math.hypot(this.#force[3 * row], this.#force[3 * row + 1], this.#force[3 * row + 2]);
  }
  moveTo(frame) {
    for (let i = 0; i < this.count; ++i) {
      const begin = this.#first[i];
      const end = this.#first[i + 1];
      const row = begin < end ? lastNotAbove(this.#frame, frame, begin, end) : -1;
      this.#rows[i] = row >= 0 && this.#frame[row] <= frame ? row : -1;
    }
  }
  depth(i) {
    return this.#rows[i] < 0 ? 0 : this.#depth[this.#rows[i]] / 255;
  }
  state(i) {
    return this.#rows[i] < 0 ? 0 : this.#state[this.#rows[i]];
  }
  /** [N] Size of the force on what a sensor touches. */
  force(i) {
    return this.#rows[i] < 0 ? 0 : this.#size(this.#rows[i]);
  }
  /** [N] The force as numbers of a vector, in the body's frame. */
  forceVector(i) {
    const row = this.#rows[i];
    return row < 0 ? [0, 0, 0] : [0, 1, 2].map((k) => this.newton * this.#force[3 * row + k]);
  }
  /** [N], [-] Of all frames: length of the sum of all forces, and sensors that slip. */
  totals(frames) {
    const changes = Array.from({ length: 4 }, () => new Float64Array(frames));
    const add = (row, frame, sign) => {
      // Whole steps, whose sums are exact.
      for (let k = 0; k < 3; ++k) changes[k][frame] += sign * this.#force[3 * row + k];
      if (this.#state[row] === slipping) changes[3][frame] += sign;
    };
    for (let i = 0; i < this.count; ++i) {
      for (let row = this.#first[i]; row < this.#first[i + 1]; ++row) {
        add(row, this.#frame[row], 1);
        if (row + 1 < this.#first[i + 1]) add(row, this.#frame[row + 1], -1);
      }
    }
    const force = new Float64Array(frames);
    const slips = new Float64Array(frames);
    const sum = [0, 0, 0, 0];
    for (let frame = 0; frame < frames; ++frame) {
      for (let k = 0; k < 4; ++k) sum[k] += changes[k][frame];
      force[frame] = this.newton * Math.hypot(sum[0], sum[1], sum[2]);
      slips[frame] = sum[3];
    }
    return { force, slips };
  }
}

export class Tracks {
  constructor(glb) {
    const json = glb.json.extras?.bristle ?? {};
    if ((json.version ?? 1) !== 1) throw new Error(`its tracks have version ${json.version}; this page reads version 1`);
    this.times = glb.numbers(json.times);
    this.patches = (json.patches ?? []).map((patch) => new PatchTrack(glb, patch));
    this.joints = (json.joints ?? []).map((joint) => ({
      ...joint,
      positions: glb.numbers(joint.position),
      motorForces: glb.numbers(joint.motor_force),
    }));
    this.channels = (json.channels ?? []).map((channel) => ({ ...channel, values: glb.numbers(channel.values) }));
    this.contacts = {
      first: glb.numbers(json.contacts?.first),
      nodes: glb.numbers(json.contacts?.node),
      points: glb.numbers(json.contacts?.point),
      forces: glb.numbers(json.contacts?.force),
    };
  }
  frameAt(time) {
    return lastNotAbove(this.times, time + 1e-6, 0, this.times.length);
  }

  /** All that can be plotted: {name, unit, values, first, isShown}. */
  curves() {
    const frames = this.times.length;
    const curves = this.channels.map(({ name, unit, values, first_frame: first }) => ({ name, unit, values, first, isShown: true }));
    for (const patch of this.patches) {
      const { force, slips } = patch.totals(frames);
      const isShown = patch.largest > 0 && this.patches.length <= 4;
      curves.push({ name: `${patch.name}: force`, unit: 'N', values: force, first: 0, isShown });
      curves.push({ name: `${patch.name}: slipping sensors`, unit: '', values: slips, first: 0, isShown });
    }
    for (const { name, kind, positions, motorForces } of this.joints) {
      if (positions.length === 0) continue;
      const isShown = this.joints.length <= 4;
      const [unit, forceUnit] = kind === 'turns' ? ['rad', 'N m'] : ['m', 'N'];
      curves.push({ name: `${name}: position`, unit, values: positions, first: 0, isShown });
      curves.push({ name: `${name}: motor`, unit: forceUnit, values: motorForces, first: 0, isShown });
    }
    return curves;
  }
}
