// Tests the page of a recording with ten thousand sensors, NAME.html in the current folder, and
// prints how many frames a second it draws: node many_sensors_test.mjs NAME
// SPDX-License-Identifier: BSD-3-Clause
import assert from 'node:assert/strict';
import { Page, find, isForce, isStuck } from './browser.mjs';

const page = await Page.open(`${process.argv[2]}.html`);
const opened = Date.now();
await page.until("document.body?.dataset.ready === 'yes'");
console.log(`opened in ${((Date.now() - opened) / 1000).toFixed(1)} s`);
await page.setTime(3);
assert.ok(find(await page.pixels(), isForce).count > 1000, 'forces are seen');
assert.ok(find(await page.pixels('#images canvas'), isStuck).count > 5000, 'stuck sensors are seen');
const { x, y } = await page.middleOf('#images canvas');
await page.click(x, y);
const [, patch] = (await page.text('picked')).split('\n');
console.log(patch);
assert.match(patch, /^first pad: 5000 sensors, 5000 touching, /);

// Played while all sensors push.
const rate = await page.evaluate(`new Promise((done) => {
  document.getElementById('play').click();
  let frames = 0;
  let start;
  const next = (now) => {
    start ??= now;
    if (now - start > 3000) return done((1000 * frames) / (now - start));
    ++frames;
    requestAnimationFrame(next);
  };
  requestAnimationFrame(next);
})`);
console.log(`10,000 sensors: ${rate.toFixed(1)} frames a second, drawn by the processor`);
assert.ok(Number(await page.evaluate("document.getElementById('time').value")) > 3, 'it plays');
assert.deepEqual(page.errors, []);
await page.close();
