// Sensors, contacts, joints and their forces.
// SPDX-License-Identifier: BSD-3-Clause
import * as THREE from 'three';
import { colourOfState, colours } from './colours.js';
import { Copies } from './copies.js';

const up = new THREE.Vector3(0, 1, 0);
const colourOf = ([r, g, b]) => new THREE.Color().setRGB(r / 255, g / 255, b / 255, THREE.SRGBColorSpace);

/** More sensors than that are drawn with the fewest triangles that show a place and a direction. */
export const manySensors = 1000;

/** Three corners and one above them. */
function spike(radius, low, high) {
  const corners = [0, 1, 2].map((i) => (2 * Math.PI * i) / 3).flatMap((angle) => [radius * Math.cos(angle), low, radius * Math.sin(angle)]);
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.Float32BufferAttribute([...corners, 0, high, 0], 3));
  geometry.setIndex([0, 2, 1, 0, 3, 2, 2, 3, 1, 1, 3, 0]);
  return geometry;
}

/** Eight triangles around a point. */
function ball(radius) {
  const points = [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]];
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.Float32BufferAttribute(points.flat().map((x) => radius * x), 3));
  geometry.setIndex([0, 1, 2, 3].flatMap((i) => [i, (i + 1) % 4, 4, (i + 1) % 4, i, 5]));
  return geometry;
}

/** An arrow along y, one long. */
function arrowGeometry(isSimple) {
  if (isSimple) return spike(0.06, 0, 1);
  const profile = [[0, 0], [0.03, 0], [0.03, 0.75], [0.08, 0.75], [0, 1]];
  return new THREE.LatheGeometry(profile.map(([x, y]) => new THREE.Vector2(x, y)), 6);
}

/** Arrows at points, as many as are added after `clear`. */
class Arrows {
  #place = new THREE.Object3D();
  #direction = new THREE.Vector3();
  /** Numbers of what the arrows belong to. */
  owners = [];

  /** @param thickest  [m] Of which length an arrow has the thickness of the longest. */
  constructor(most, thickest, looks) {
    this.copies = new Copies(arrowGeometry(most > manySensors), most, looks);
    this.mesh = this.copies.mesh;
    this.thickest = thickest;
  }
  clear() {
    this.owners.length = 0;
  }
  add(owner, point, vector, scale) {
    const length = Math.hypot(...vector);
    if (!(length > 0)) return;
    this.#place.position.fromArray(point);
    this.#place.quaternion.setFromUnitVectors(up, this.#direction.fromArray(vector).divideScalar(length));
    const thickness = Math.min(length * scale, this.thickest);
    this.#place.scale.set(thickness, length * scale, thickness);
    this.#place.updateMatrix();
    this.copies.setMatrix(this.owners.length, this.#place.matrix);
    this.owners.push(owner);
  }
  finish() {
    this.copies.count = this.owners.length;
    this.copies.update();
  }
  /** Number of what an arrow belongs to that a ray met. */
  ownerAt(faceIndex) {
    return this.owners[this.copies.copyAt(faceIndex)];
  }
}

/** [m] Of the nearest other sensor, in the middle of a few. */
export function spacingOf(ends) {
  const count = ends.length / 3;
  const distances = [];
  for (let i = 0; i < count; i += Math.max(1, Math.floor(count / 20))) {
    let nearest = Infinity;
    for (let k = 0; k < count; ++k) {
      if (k === i) continue;
      nearest = Math.min(nearest, Math.hypot(ends[3 * i] - ends[3 * k], ends[3 * i + 1] - ends[3 * k + 1], ends[3 * i + 2] - ends[3 * k + 2]));
    }
    distances.push(nearest);
  }
  distances.sort((a, b) => a - b);
  const middle = distances[distances.length >> 1];
  return Number.isFinite(middle) && middle > 0 ? middle : undefined;
}

/**
 * The sensors of a patch, on its body: a dot each, in the colour of its state, and its force. They
 * press into what they touch, so nothing hides them.
 */
export class PatchView {
  #colour = new THREE.Color();

  constructor(track, body, largestDot) {
    this.track = track;
    this.body = body;
    const spacing = spacingOf(track.ends) ?? 3 * largestDot;
    const radius = Math.min(0.3 * spacing, largestDot);
    const isMany = track.count > manySensors;
    this.dots = new Copies(isMany ? spike(1.3 * radius, -radius, radius) : ball(radius), track.count, { isSeenThroughAll: true });
    this.dots.count = track.count;
    const matrix = new THREE.Matrix4();
    for (let i = 0; i < track.count; ++i) this.dots.setMatrix(i, matrix.makeTranslation(...this.end(i)));
    this.arrows = new Arrows(track.count, 2.5 * spacing, { colour: colourOf(colours.force), isSeenThroughAll: true });
    this.dots.mesh.userData.view = this.arrows.mesh.userData.view = this;
    body.add(this.dots.mesh, this.arrows.mesh);
  }
  end(i) {
    return this.track.ends.subarray(3 * i, 3 * i + 3);
  }
  update(frame, scale) {
    const { track, dots, arrows } = this;
    track.moveTo(frame);
    arrows.clear();
    for (let i = 0; i < track.count; ++i) {
      const [r, g, b] = colourOfState(track.state(i), track.depth(i));
      dots.setColour(i, this.#colour.setRGB(r / 255, g / 255, b / 255, THREE.SRGBColorSpace));
      if (track.state(i) !== 0) arrows.add(i, this.end(i), track.forceVector(i), scale);
    }
    dots.update();
    arrows.finish();
  }
  /** Number of the sensor whose dot or arrow a ray met. */
  sensorAt({ object, faceIndex }) {
    return object === this.dots.mesh ? this.dots.copyAt(faceIndex) : this.arrows.ownerAt(faceIndex);
  }
}

/** The contacts of a frame, as arrows in the world. */
export class ContactView {
  constructor(contacts, world) {
    this.contacts = contacts;
    const { first } = contacts;
    let most = 0;
    for (let frame = 0; frame + 1 < first.length; ++frame) most = Math.max(most, first[frame + 1] - first[frame]);
    this.arrows = new Arrows(Math.max(most, 1), Infinity, { colour: colourOf(colours.contact) });
    this.arrows.mesh.userData.contacts = this;
    world.add(this.arrows.mesh);
  }
  /** [N] The largest force of any frame. */
  largest() {
    let largest = 0;
    for (let i = 0; i < this.contacts.forces.length; i += 3) {
      largest = Math.max(largest, Math.hypot(...this.contacts.forces.subarray(i, i + 3)));
    }
    return largest;
  }
  update(frame, scale) {
    const { first, points, forces } = this.contacts;
    this.arrows.clear();
    for (let i = first[frame] ?? 0; i < (first[frame + 1] ?? 0); ++i) {
      this.arrows.add(i, points.subarray(3 * i, 3 * i + 3), forces.subarray(3 * i, 3 * i + 3), scale);
    }
    this.arrows.finish();
  }
}

/** The axis of a joint, on its body. */
export function jointLine(node, length, userData) {
  const points = [new THREE.Vector3(-length, 0, 0), new THREE.Vector3(length, 0, 0)];
  const line = new THREE.Line(
    new THREE.BufferGeometry().setFromPoints(points),
    new THREE.LineBasicMaterial({ color: colourOf(colours.joint), depthTest: false, transparent: true }),
  );
  line.userData = userData;
  node.add(line);
  return line;
}
