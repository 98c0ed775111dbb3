// Tests the recording of gripper_on_incline and its page, NAME.glb and NAME.html in the current
// folder: node replay_test.mjs NAME
// SPDX-License-Identifier: BSD-3-Clause
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { Glb } from '../../examples/replay/glb.js';
import { Tracks } from '../../examples/replay/tracks.js';
import { Page, colours, difference, find, isContact, isForce, isFree, isSlipping, isStuck } from './browser.mjs';

const name = process.argv[2];
const bytes = readFileSync(`${name}.glb`);

const page = await Page.open(`${name}.html`);
await page.until("document.body?.dataset.ready === 'yes'");
await page.drawn();
const start = await page.pixels();
assert.ok(colours(start) > 50, 'the canvas shows something');
assert.equal(find(start, isForce).count, 0, 'nothing is touched yet');
assert.ok(find(start, isFree).count > 100, 'free sensors are seen');
assert.equal(find(start, isStuck).count, 0, 'none is stuck');
// The part stands on the incline, which pushes it.
await page.clickPixel(find(start, isContact).first);
console.log(`picked: ${await page.text('picked')}`);
const support = Number((await page.text('picked')).match(/^contact on part: .* mm, (\S+) N$/)?.[1]);
assert.ok(support > 0.1 && support < 0.5 * 9.81, 'a part of the weight');

// Held up after 3 s: elsewhere, with stuck sensors, with arrows, and without the incline.
await page.setTime(3);
const held = await page.pixels();
console.log(`pixels: ${difference(start, held)} of ${held.length / 4} differ, ${find(held, isForce).count} of arrows, ${find(held, isStuck).count} of stuck sensors`);
assert.ok(difference(start, held) > 5000, 'the part has moved');
assert.ok(find(held, isForce).count > 100, 'forces are seen');
assert.ok(find(held, isStuck).count > 100, 'stuck sensors are seen');
assert.equal(find(held, isSlipping).count, 0, 'none slips');
assert.equal(find(held, isContact).count, 0, 'nothing but sensors holds it');
assert.equal(await page.text('clock'), '3.000 s');
await page.picture(`${name}.png`);

// What is switched off is not drawn.
const click = (id) => page.evaluate(`document.getElementById('${id}').click()`);
for (const [id, is] of [['show-forces', isForce], ['show-sensors', isStuck]]) {
  await click(id);
  await page.drawn();
  assert.equal(find(await page.pixels(), is).count, 0, id);
  await click(id);
}
await page.drawn();
assert.equal(difference(held, await page.pixels()), 0);

// Sensors that let go have another colour at that time.
const tracks = new Tracks(new Glb(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength)));
const { slips } = tracks.patches[0].totals(tracks.times.length);
const slide = slips.indexOf(Math.max(...slips));
await page.setTime(tracks.times[slide]);
const sliding = await page.pixels();
console.log(`${slips[slide]} sensors of the first pad slip at ${tracks.times[slide].toFixed(2)} s, ${find(sliding, isSlipping).count} pixels of slipping ones`);
assert.ok(find(sliding, isSlipping).count > 100, 'slipping sensors are seen');

// Back at the start it looks as it did.
await page.setTime(0);
assert.equal(difference(start, await page.pixels()), 0);

// The cursor of all plots follows the time, and values stand beside the names.
const plots = () => page.evaluate(`[...document.querySelectorAll('.plot')].map((plot) => ({
  x: Number(plot.querySelector('.cursor').getAttribute('x1')), wide: plot.querySelector('svg').viewBox.baseVal.width,
  values: Object.fromEntries([...plot.querySelectorAll('li')].map((li) =>
    [li.querySelector('span').textContent, li.querySelector('output').textContent])) }))`);
const duration = Number(await page.evaluate("document.getElementById('time').max"));
for (const t of [3, 9.5]) {
  await page.setTime(t);
  const shown = await plots();
  assert.ok(shown.length >= 3, 'a plot for each unit');
  for (const { x, wide } of shown) assert.ok(Math.abs(x / wide - t / duration) < 1e-3, 'cursor');
}
await page.setTime(3);
const values = Object.assign({}, ...(await plots()).map((plot) => plot.values));
console.log(`plots: ${JSON.stringify(values)}`);
assert.ok(Math.abs(Number(values['grip force']) - 40) < 0.1, 'two fingers of 20 N');
// 20 N squeeze the pad, which carries half the weight.
assert.ok(Math.abs(Number(values['first pad: force']) - Math.hypot(20, 0.25 * 9.81)) < 0.02);
assert.ok(Math.abs(Number(values['second slide: motor']) - 20) < 0.1);
const plot = await page.middleOf('.plot svg');
await page.click(plot.x, plot.y);
assert.ok(Math.abs(Number((await page.text('clock')).replace(' s', '')) - duration / 2) < 0.1, 'a click on a plot is a time');

// A curve that is not chosen has no plot.
const choose = (curve) => page.evaluate(`[...document.querySelectorAll('#curves label')].find((label) => label.textContent.includes('${curve}')).querySelector('input').click()`);
await choose('sag');
assert.equal((await plots()).some((each) => 'sag' in each.values), false);
await choose('sag');
assert.ok((await plots()).some((each) => 'sag' in each.values));

// The image of a patch shows what it feels, and a click on a cell picks the sensor.
await page.setTime(0);
const untouched = await page.pixels('#images canvas');
await page.setTime(3);
const image = await page.pixels('#images canvas');
console.log(`image: ${find(image, isStuck).count} of ${image.length / 4} pixels of stuck sensors`);
assert.equal(find(untouched, isStuck).count, 0);
assert.ok(find(image, isStuck).count > image.length / 4 / 2);
// It shows forces when asked to.
await page.evaluate("(() => { const e = document.getElementById('channel'); e.value = 'force'; e.dispatchEvent(new Event('change')); })()");
const forces = await page.pixels('#images canvas');
assert.ok(difference(image, forces) > image.length / 4 / 2, 'forces look otherwise than states');
const middle = await page.middleOf('#images canvas');
await page.click(middle.x, middle.y);
const [sensor, patch] = (await page.text('picked')).split('\n');
console.log(`picked: ${sensor}; ${patch}`);
const [, depth, newtons] = sensor.match(/^first pad \d+: .* mm, depth (\S+), stuck, (\S+) N$/) ?? [];
assert.ok(depth > 0.3 && depth < 0.7 && Math.abs(newtons - 20 / 60) < 0.2, 'a sensor and its numbers');
assert.match(patch, /^first pad: 60 sensors, 60 touching, 0 slipping, 20\.1\d+ N$/);

// What is picked says where it is, at each time.
const { x, y } = await page.middleOf('#canvas');
await page.click(10, 10);
assert.equal(await page.text('picked'), '', 'nothing is there');
const height = async () => Number((await page.text('picked')).match(/^part: \(\S+, \S+, (\S+)\) mm/)?.[1]);
for (let dy = 0; Number.isNaN(await height()) && dy < y; dy += 8) await page.click(x, y - dy);
const high = await height();
await page.setTime(0);
const low = await height();
console.log(`picked: the part, ${low} mm high at the start and ${high} mm in the hand`);
assert.ok(Math.abs(high - low - 120) < 1, 'lifted by 120 mm, less the sag');

// An arrow is its sensor.
await page.setTime(3);
await page.clickPixel(find(await page.pixels(), isForce).first);
assert.match(await page.text('picked'), /^(?:first|second) pad \d+: .* mm, depth \S+, stuck, 0\.\d+ N\n/);

// It plays, and stops when told to.
await click('play');
await page.until("Number(document.getElementById('time').value) > 3.2");
await click('play');
const stopped = await page.text('clock');
await page.drawn();
assert.equal(await page.text('clock'), stopped);
assert.deepEqual(page.errors, []);
await page.close();
