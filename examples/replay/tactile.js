// A patch as an image: its sensors as cells, seen along their rays.
// SPDX-License-Identifier: BSD-3-Clause
import { colourOfPart, colourOfState } from './colours.js';
import { spacingOf } from './things.js';

const size = 140;

/** Two directions across a patch: the library's `tangent_basis` of the mean of its rays. */
function basisOf(directions) {
  const n = [0, 0, 0];
  for (let i = 0; i < directions.length; ++i) n[i % 3] += directions[i];
  const length = Math.hypot(...n);
  const [x, y, z] = length > 0 ? n.map((c) => c / length) : [0, 0, 1];
  const sign = z < 0 ? -1 : 1;
  const a = -1 / (sign + z);
  const b = x * y * a;
  return [[1 + sign * x * x * a, sign * b, -sign * x], [b, sign + y * y * a, -y]];
}

export class TactileImage {
  /** Which sensor each pixel shows; -1: none. */
  #sensors = new Int32Array(size * size).fill(-1);

  constructor(view, parent, onPick) {
    this.track = view.track;
    const figure = document.createElement('figure');
    this.canvas = document.createElement('canvas');
    this.canvas.width = this.canvas.height = size;
    this.canvas.setAttribute('aria-label', `Sensors of ${view.track.name}`);
    const caption = document.createElement('figcaption');
    caption.textContent = view.track.name;
    figure.append(this.canvas, caption);
    parent.append(figure);
    this.context = this.canvas.getContext('2d');
    this.image = this.context.createImageData(size, size);
    this.#place();
    this.canvas.addEventListener('click', (event) => {
      const at = [event.offsetX, event.offsetY].map((x) => Math.floor((x * size) / this.canvas.clientWidth));
      const sensor = this.#sensors[at[1] * size + at[0]] ?? -1;
      if (sensor >= 0) onPick(view, sensor);
    });
  }
  /** Gives each pixel the nearest sensor, if that is near. */
  #place() {
    const { ends, directions, count } = this.track;
    const [u, v] = basisOf(directions);
    const across = (i, axis) => axis[0] * ends[3 * i] + axis[1] * ends[3 * i + 1] + axis[2] * ends[3 * i + 2];
    const xs = Float64Array.from({ length: count }, (_, i) => across(i, u));
    const ys = Float64Array.from({ length: count }, (_, i) => across(i, v));
    const bounds = (values) => values.reduce(([low, high], x) => [Math.min(low, x), Math.max(high, x)], [Infinity, -Infinity]);
    const [[x0, x1], [y0, y1]] = [bounds(xs), bounds(ys)];
    const cell = spacingOf(ends) ?? 1;
    const scale = size / (Math.max(x1 - x0, y1 - y0) + cell);
    const reach = Math.max(1.6 * cell * scale, 1);
    const nearest = new Float32Array(size * size).fill(Infinity);
    for (let i = 0; i < count; ++i) {
      const px = size / 2 + (xs[i] - (x0 + x1) / 2) * scale;
      const py = size / 2 - (ys[i] - (y0 + y1) / 2) * scale;
      for (let y = Math.max(0, Math.floor(py - reach)); y <= Math.min(size - 1, py + reach); ++y) {
        for (let x = Math.max(0, Math.floor(px - reach)); x <= Math.min(size - 1, px + reach); ++x) {
          const distance = Math.hypot(x + 0.5 - px, y + 0.5 - py);
          if (distance > reach || distance >= nearest[y * size + x]) continue;
          nearest[y * size + x] = distance;
          this.#sensors[y * size + x] = i;
        }
      }
    }
  }
  #colourOf(i, channel) {
    const { track } = this;
    if (channel === 'depth') return colourOfPart(track.depth(i));
    if (channel === 'force') return colourOfPart(track.force(i) / (track.largest || 1));
    return colourOfState(track.state(i), track.depth(i));
  }
  draw(channel) {
    const sensorColours = Array.from({ length: this.track.count }, (_, i) => this.#colourOf(i, channel));
    const { data } = this.image;
    for (let pixel = 0; pixel < this.#sensors.length; ++pixel) {
      const sensor = this.#sensors[pixel];
      const [r, g, b] = sensor < 0 ? [245, 245, 247] : sensorColours[sensor];
      data.set([r, g, b, 255], 4 * pixel);
    }
    this.context.putImageData(this.image, 0, 0);
  }
}
