// Colours of the page's things. Told apart with all common kinds of colour vision.
// SPDX-License-Identifier: BSD-3-Clause
import { slipping } from './tracks.js';

export const colours = {
  free: [150, 155, 160],
  shallow: [158, 202, 225],
  deep: [8, 69, 148],
  slipping: [240, 140, 0],
  force: [204, 26, 26],
  contact: [20, 120, 60],
  joint: [130, 60, 150],
};

function between(a, b, x) {
  return a.map((from, k) => Math.round(from + x * (b[k] - from)));
}

/** Of a sensor, as three numbers of 0 to 255. */
export function colourOfState(state, depth) {
  if (state === 0) return colours.free;
  return state === slipping ? colours.slipping : between(colours.shallow, colours.deep, depth);
}

/** Of a part from 0 to 1 of a largest value. */
export function colourOfPart(x) {
  return between([255, 255, 255], colours.deep, Math.min(Math.max(x, 0), 1));
}

/** The key to them, as HTML. */
export function keyOf({ hasSensors, hasJoints, sensorScale, contactScale }) {
  const entry = (colour, text) => `<i style="background: rgb(${colour.join()})"></i>${text}`;
  const parts = [];
  if (hasSensors) {
    parts.push(entry(colours.free, 'free'), entry(colours.shallow, 'stuck'), entry(colours.deep, 'stuck, deep'));
    parts.push(entry(colours.slipping, 'slipping'));
  }
  if (sensorScale > 0) parts.push(entry(colours.force, `force, 1 N = ${sensorScale} mm`));
  if (contactScale > 0) parts.push(entry(colours.contact, `contact, 1 N = ${contactScale} mm`));
  if (hasJoints) parts.push(entry(colours.joint, 'joint'));
  return parts.join('');
}
