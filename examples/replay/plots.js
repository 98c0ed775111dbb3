// Curves over time, below each other, with one cursor.
// SPDX-License-Identifier: BSD-3-Clause

const width = 300;
const height = 80;
// Okabe and Ito (2008): told apart with all common kinds of colour vision.
const lineColours = ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#e69f00', '#56b4e9', '#333333', '#999933'];

function svg(name, attributes) {
  const element = document.createElementNS('http://www.w3.org/2000/svg', name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  return element;
}
function html(name, text, parent) {
  const element = document.createElement(name);
  element.textContent = text;
  parent?.append(element);
  return element;
}
const short = (x) => (Number.isInteger(x) ? String(x) : Math.abs(x) < 1e-3 || Math.abs(x) >= 1e5 ? x.toExponential(2) : x.toPrecision(4));

/** One frame of curves that share a unit. */
class Plot {
  constructor(unit, curves, times, parent, onTime) {
    this.curves = curves;
    this.duration = times[times.length - 1] || 1;
    const box = html('section', '', parent);
    box.className = 'plot';
    const title = html('h2', unit === '' ? 'number' : `[${unit}]`, box);
    let low = Infinity;
    let high = -Infinity;
    for (const { values } of curves) {
      for (const value of values) {
        low = Math.min(low, value);
        high = Math.max(high, value);
      }
    }
    const range = html('span', `${short(low)} to ${short(high)}`, title);
    range.className = 'range';
    if (!(high > low)) [low, high] = [low - 1, high + 1];
    this.svg = svg('svg', { viewBox: `0 0 ${width} ${height}`, preserveAspectRatio: 'none' });
    const y = (value) => height - 4 - ((value - low) / (high - low)) * (height - 8);
    if (low < 0 && high > 0) this.svg.append(svg('line', { class: 'zero', x1: 0, x2: width, y1: y(0), y2: y(0) }));
    const list = document.createElement('ul');
    this.outputs = curves.map(({ name, values, first }, i) => {
      const colour = lineColours[i % lineColours.length];
      const points = [];
      // The lowest and the highest of so many frames that a pixel has two points.
      const stride = Math.max(1, Math.floor(values.length / width));
      for (let k = 0; k < values.length; k += stride) {
        let [least, most] = [k, k];
        for (let j = k; j < Math.min(k + stride, values.length); ++j) {
          if (values[j] < values[least]) least = j;
          if (values[j] > values[most]) most = j;
        }
        for (const j of new Set([Math.min(least, most), Math.max(least, most)])) {
          points.push(`${((times[first + j] / this.duration) * width).toFixed(2)},${y(values[j]).toFixed(2)}`);
        }
      }
      this.svg.append(svg('polyline', { points: points.join(' '), stroke: colour }));
      const entry = html('li', '', list);
      entry.style.color = colour;
      html('span', name, entry);
      return html('output', '', entry);
    });
    this.cursor = svg('line', { class: 'cursor', x1: 0, x2: 0, y1: 0, y2: height });
    this.svg.append(this.cursor);
    const seek = (event) => {
      if (event.buttons !== 1) return;
      const { left, width: wide } = this.svg.getBoundingClientRect();
      onTime(((event.clientX - left) / wide) * this.duration);
    };
    this.svg.addEventListener('pointerdown', seek);
    this.svg.addEventListener('pointermove', seek);
    box.append(this.svg, list);
  }
  moveTo(time, frame) {
    const x = ((time / this.duration) * width).toFixed(3);
    this.cursor.setAttribute('x1', x);
    this.cursor.setAttribute('x2', x);
    this.curves.forEach(({ values, first }, i) => {
      const value = values[frame - first];
      this.outputs[i].textContent = value === undefined ? '' : short(value);
    });
  }
}

/** The plots of a recording, and which curves they show. */
export class Plots {
  #plots = [];
  #last = [0, 0];

  constructor(curves, times, { plots, list, onTime }) {
    this.curves = curves;
    const draw = () => {
      plots.replaceChildren();
      const shown = curves.filter(({ isShown, values }) => isShown && values.length > 0);
      const units = [...new Set(shown.map(({ unit }) => unit))];
      this.#plots = units.map((unit) => new Plot(unit, shown.filter((curve) => curve.unit === unit), times, plots, onTime));
      this.moveTo(...this.#last);
    };
    for (const curve of curves) {
      const label = html('label', '', list);
      const box = html('input', '', label);
      box.type = 'checkbox';
      box.checked = curve.isShown;
      label.append(` ${curve.name}${curve.unit === '' ? '' : ` [${curve.unit}]`}`);
      box.addEventListener('change', () => {
        curve.isShown = box.checked;
        draw();
      });
    }
    list.hidden = curves.length === 0;
    draw();
  }
  moveTo(time, frame) {
    this.#last = [time, frame];
    for (const plot of this.#plots) plot.moveTo(time, frame);
  }
}
