// Tests that a page whose recording is damaged says so: node damaged_test.mjs NAME, with NAME.html in
// the current folder.
// SPDX-License-Identifier: BSD-3-Clause
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { gunzipSync, gzipSync } from 'node:zlib';
import { Page } from './browser.mjs';

const whole = readFileSync(`${process.argv[2]}.html`, 'utf8');
const [, packed] = whole.match(/<script id="recording"[^>]*>([^<]*)/);
const recording = gunzipSync(Buffer.from(packed, 'base64'));
const pageOf = (bytes) => whole.replace(packed, gzipSync(bytes).toString('base64'));

/** The recording with other JSON of the same length. */
function withJson(change) {
  const bytes = Buffer.from(recording);
  const size = bytes.readUInt32LE(12);
  const json = change(bytes.toString('utf8', 20, 20 + size));
  assert.equal(Buffer.byteLength(json), size);
  bytes.write(json, 20);
  return bytes;
}

const cases = [
  ['text cut', whole.replace(packed, packed.slice(0, 4000)), /cannot be read: it ends too early/],
  ['text damaged', whole.replace(packed, `${packed.slice(0, 4000)}*`), /cannot be read: its text is damaged/],
  ['half written', pageOf(recording.subarray(0, 100000)), /cannot be read: it has 100000 bytes and should have \d+/],
  ['no recording', pageOf(Buffer.from('a recording')), /cannot be read: it is no \.glb file/],
  ['accessor too long', pageOf(withJson((json) => json.replace(/("componentType":5126,"count":)1/, '$19'))), /cannot be read: its accessor \d+ does not fit/],
  ['JSON cut', pageOf(withJson((json) => json.slice(0, -9) + ' '.repeat(9))), /cannot be read: its JSON is damaged/],
  ['later version', pageOf(withJson((json) => json.replace('"version":1,', '"version":2,'))), /version 2; this page reads version 1/],
  ['page cut in the recording', whole.slice(0, whole.indexOf(packed) + 5000), /page is cut short/],
  ['page cut in the viewer', whole.slice(0, -5000), /page is cut short/],
];
const page = await Page.open('about:blank');
for (const [what, html, wanted] of cases) {
  writeFileSync('damaged.html', html);
  await page.go('damaged.html');
  await page.until("document.getElementById('error')?.textContent && !document.getElementById('error').hidden");
  const message = await page.text('error');
  console.log(`${what}: ${message}`);
  assert.match(message, wanted, what);
}
await page.close();
