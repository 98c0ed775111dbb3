// Tests recordings and their pages: Khronos' validator has no error and no warning, the page opens,
// shows something, and something else at its end: node valid_test.mjs NAME..., with NAME.glb and
// NAME.html in the current folder.
// SPDX-License-Identifier: BSD-3-Clause
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { Page, colours, difference } from './browser.mjs';

const validator = createRequire(join(process.env.NODE_PATH, 'x.js'))('gltf-validator');

const page = await Page.open('about:blank');
for (const name of process.argv.slice(2)) {
  const { issues } = await validator.validateBytes(new Uint8Array(readFileSync(`${name}.glb`)));
  console.log(`${name}: ${issues.numErrors} errors, ${issues.numWarnings} warnings of the validator`);
  assert.equal(issues.numErrors, 0, JSON.stringify(issues.messages));
  assert.equal(issues.numWarnings, 0, JSON.stringify(issues.messages));
  await page.go(`${name}.html`);
  await page.until("document.body?.dataset.ready === 'yes'");
  await page.drawn();
  const start = await page.pixels();
  assert.ok(colours(start) > 20, `${name}: the canvas shows something`);
  await page.setTime(await page.evaluate("document.getElementById('time').max"));
  assert.ok(difference(start, await page.pixels()) > 100, `${name}: it moves`);
  assert.deepEqual(page.errors, [], name);
}
await page.close();
