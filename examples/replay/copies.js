// Many copies of one small shape in one mesh.
//
// Not THREE.InstancedMesh: a renderer without a graphics card (SwiftShader) takes each instance for
// a draw of its own, and draws ten thousand of them a third as often.
// SPDX-License-Identifier: BSD-3-Clause
import * as THREE from 'three';

export class Copies {
  #shape;
  #corners;
  #positions;
  #colours;
  #point = new THREE.Vector3();

  /**
   * @param {THREE.BufferGeometry} shape  With an index.
   * @param {number} most                 So many copies at most; `count` of them are drawn.
   * @param {THREE.Color} [colour]        Of all of them; else each has its own.
   * @param {boolean} [isSeenThroughAll]  Whether nothing hides them.
   */
  constructor(shape, most, { colour, isSeenThroughAll = false } = {}) {
    this.#shape = shape.getAttribute('position');
    const index = shape.getIndex();
    this.#corners = index.count;
    const points = this.#shape.count;
    this.geometry = new THREE.BufferGeometry();
    this.#positions = new THREE.BufferAttribute(new Float32Array(3 * most * points), 3);
    this.geometry.setAttribute('position', this.#positions);
    const all = new Uint32Array(most * index.count);
    for (let i = 0; i < all.length; ++i) all[i] = Math.floor(i / index.count) * points + index.getX(i % index.count);
    this.geometry.setIndex(new THREE.BufferAttribute(all, 1));
    const looks = { transparent: true };
    if (colour) {
      looks.color = colour;
    } else {
      looks.vertexColors = true;
      this.#colours = new THREE.BufferAttribute(new Float32Array(3 * most * points), 3);
      this.geometry.setAttribute('color', this.#colours);
    }
    // As the last of what is transparent: bodies that are seen through do not tint them.
    this.mesh = new THREE.Mesh(this.geometry, new THREE.MeshBasicMaterial(looks));
    this.mesh.renderOrder = 1;
    this.mesh.material.depthTest = !isSeenThroughAll;
    // Its bounds change from frame to frame.
    this.mesh.frustumCulled = false;
    this.count = 0;
  }
  set count(count) {
    this.geometry.setDrawRange(0, count * this.#corners);
  }
  /** @param {THREE.Matrix4} matrix */
  setMatrix(i, matrix) {
    const points = this.#shape.count;
    for (let k = 0; k < points; ++k) {
      this.#point.fromBufferAttribute(this.#shape, k).applyMatrix4(matrix).toArray(this.#positions.array, 3 * (i * points + k));
    }
  }
  /** @param {THREE.Color} colour */
  setColour(i, colour) {
    const points = this.#shape.count;
    for (let k = 0; k < points; ++k) colour.toArray(this.#colours.array, 3 * (i * points + k));
  }
  /** To be called after changes. */
  update() {
    this.#positions.needsUpdate = true;
    if (this.#colours) this.#colours.needsUpdate = true;
    this.geometry.boundingSphere = null;
  }
  /** Number of the copy that a ray met, by the triangle that it met. */
  copyAt(faceIndex) {
    return Math.floor((3 * faceIndex) / this.#corners);
  }
}
