// A binary glTF file: its JSON, its numbers, and itself without what the page draws in another way.
// SPDX-License-Identifier: BSD-3-Clause

const magic = 0x46546c67;
const jsonChunk = 0x4e4f534a;
const binaryChunk = 0x004e4942;
const arrays = {
  5121: Uint8Array,
  5122: Int16Array,
  5123: Uint16Array,
  5125: Uint32Array,
  5126: Float32Array,
};
const widths = { SCALAR: 1, VEC3: 3, VEC4: 4 };

function parsed(bytes) {
  try {
    return JSON.parse(new TextDecoder().decode(bytes));
  } catch (error) {
    throw new Error(`its JSON is damaged: ${error.message}`);
  }
}

/** A file as bristle's `glb` writes it: one buffer, an accessor for each of its views. */
export class Glb {
  /** @param {ArrayBuffer} bytes  Throws an Error that says what is wrong with them. */
  constructor(bytes) {
    const view = new DataView(bytes);
    if (bytes.byteLength < 20 || view.getUint32(0, true) !== magic) throw new Error('it is no .glb file');
    const length = view.getUint32(8, true);
    if (length !== bytes.byteLength) {
      throw new Error(`it has ${bytes.byteLength} bytes and should have ${length}: it is cut short, or has more after its end`);
    }
    for (let at = 12; at + 8 <= length; ) {
      const size = view.getUint32(at, true);
      if (at + 8 + size > length) throw new Error(`its chunk at byte ${at} reaches beyond its end`);
      const type = view.getUint32(at + 4, true);
      if (type === jsonChunk) this.json = parsed(new Uint8Array(bytes, at + 8, size));
      if (type === binaryChunk) this.binary = new Uint8Array(bytes, at + 8, size);
      at += 8 + size;
    }
    if (!this.json) throw new Error('it has no JSON');
    (this.json.accessors ?? []).forEach((_, index) => this.#bytesOf(index));
  }

  /** The bytes of an accessor, and how to read them. */
  #bytesOf(index) {
    const { bufferView, componentType, count, type } = this.json.accessors?.[index] ?? {};
    const { byteOffset, byteLength } = this.json.bufferViews?.[bufferView] ?? {};
    const Numbers = arrays[componentType];
    const size = count * widths[type] * (Numbers?.BYTES_PER_ELEMENT ?? NaN);
    if (size !== byteLength || !(byteOffset + byteLength <= this.binary?.byteLength)) {
      throw new Error(`its accessor ${index} does not fit into its buffer`);
    }
    return { Numbers, bytes: this.binary.slice(byteOffset, byteOffset + byteLength).buffer };
  }

  /** All numbers of an accessor; none where there is no accessor. */
  numbers(index) {
    if (index === undefined) return new Float32Array();
    const { Numbers, bytes } = this.#bytesOf(index);
    return new Numbers(bytes);
  }

  /** The file without nodes that `isLeftOut` says, their meshes and their animation. */
  without(isLeftOut) {
    const json = structuredClone(this.json);
    json.nodes.forEach((node) => {
      if (isLeftOut(node)) delete node.mesh;
      if (node.children) node.children = node.children.filter((i) => !isLeftOut(json.nodes[i]));
      if (node.children?.length === 0) delete node.children;
    });
    for (const animation of json.animations ?? []) {
      animation.channels = animation.channels.filter(({ target }) => !isLeftOut(json.nodes[target.node]));
    }
    json.animations = json.animations?.filter(({ channels }) => channels.length > 0);
    const text = new TextEncoder().encode(JSON.stringify(json));
    const jsonSize = Math.ceil(text.length / 4) * 4;
    const bytes = new Uint8Array(20 + jsonSize + 8 + this.binary.byteLength).fill(0x20);
    const view = new DataView(bytes.buffer);
    [magic, 2, bytes.length, jsonSize, jsonChunk].forEach((x, i) => view.setUint32(4 * i, x, true));
    bytes.set(text, 20);
    view.setUint32(20 + jsonSize, this.binary.byteLength, true);
    view.setUint32(24 + jsonSize, binaryChunk, true);
    bytes.set(this.binary, 28 + jsonSize);
    return bytes.buffer;
  }
}
