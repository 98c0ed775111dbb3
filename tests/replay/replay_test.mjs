// Tests a recording and its page, NAME.glb and NAME.html in the current folder: node replay_test.mjs NAME
// SPDX-License-Identifier: BSD-3-Clause
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

const name = process.argv[2];
const validator = createRequire(join(process.env.NODE_PATH, 'x.js'))('gltf-validator');

/** A page in a browser, spoken to by the DevTools protocol over a pipe. */
class Page {
  #browser;
  #profile = mkdtempSync(join(tmpdir(), 'replay-'));
  #session;
  #number = 0;
  #waiting = new Map();
  /** What the page complained about. */
  errors = [];

  static async open(file) {
    const page = new Page();
    page.#browser = spawn(
      'chromium',
      ['--headless=new', '--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
        '--remote-debugging-pipe', '--window-size=900,600', `--user-data-dir=${page.#profile}`],
      { stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe'] },
    );
    let text = '';
    page.#browser.stdio[4].on('data', (bytes) => {
      text += bytes;
      const messages = text.split('\0');
      text = messages.pop();
      for (const message of messages) page.#receive(JSON.parse(message));
    });
    const { targetId } = await page.send('Target.createTarget', { url: 'about:blank' });
    const { sessionId } = await page.send('Target.attachToTarget', { targetId, flatten: true });
    page.#session = sessionId;
    for (const domain of ['Page', 'Runtime', 'Log']) await page.send(`${domain}.enable`);
    await page.send('Page.navigate', { url: pathToFileURL(resolve(file)).href });
    return page;
  }
  #receive({ id, method, params, result, error }) {
    if (id) {
      const { done, failed } = this.#waiting.get(id);
      this.#waiting.delete(id);
      error ? failed(new Error(error.message)) : done(result);
    } else if (method === 'Runtime.exceptionThrown') {
      this.errors.push(params.exceptionDetails.text);
    } else if (method === 'Runtime.consoleAPICalled' && params.type === 'error') {
      this.errors.push(params.args.map((a) => a.value).join(' '));
    } else if (method === 'Log.entryAdded' && params.entry.level === 'error') {
      this.errors.push(params.entry.text);
    }
  }
  send(method, params = {}) {
    const id = ++this.#number;
    this.#browser.stdio[3].write(`${JSON.stringify({ id, method, params, sessionId: this.#session })}\0`);
    return new Promise((done, failed) => this.#waiting.set(id, { done, failed }));
  }
  async evaluate(expression) {
    const { result, exceptionDetails } = await this.send('Runtime.evaluate', {
      expression, returnByValue: true, awaitPromise: true,
    });
    assert.equal(exceptionDetails, undefined, `${expression}: ${exceptionDetails?.text}`);
    return result.value;
  }
  /** Waits until an expression is true, 20 s at most. */
  async until(expression) {
    for (let i = 0; i < 200; ++i) {
      if (await this.evaluate(expression)) return;
      await new Promise((done) => setTimeout(done, 100));
    }
    assert.fail(`never: ${expression}`);
  }
  /** Two frames later all that was asked for is drawn. */
  drawn() {
    return this.evaluate('new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))');
  }
  async setTime(t) {
    await this.evaluate(`(() => { const e = document.getElementById('time'); e.value = ${t};
      e.dispatchEvent(new Event('input')); })()`);
    await this.drawn();
  }
  /** All pixels of the canvas, four bytes each. */
  async pixels() {
    const text = await this.evaluate(`(() => { const from = document.getElementById('canvas');
      const to = new OffscreenCanvas(from.width, from.height); const context = to.getContext('2d');
      context.drawImage(from, 0, 0);
      const data = context.getImageData(0, 0, to.width, to.height).data;
      let s = ''; for (let i = 0; i < data.length; i += 32768) s += String.fromCharCode(...data.subarray(i, i + 32768));
      return btoa(s); })()`);
    return Buffer.from(text, 'base64');
  }
  async click(x, y) {
    for (const type of ['mousePressed', 'mouseReleased']) {
      await this.send('Input.dispatchMouseEvent', { type, x, y, button: 'left', clickCount: 1 });
    }
    await this.drawn();
  }
  text(id) {
    return this.evaluate(`document.getElementById('${id}').textContent`);
  }
  async picture(file) {
    const { data } = await this.send('Page.captureScreenshot', { format: 'png' });
    writeFileSync(file, Buffer.from(data, 'base64'));
  }
  async close() {
    await this.send('Browser.close').catch(() => {});
    await new Promise((done) => this.#browser.on('close', done));
    rmSync(this.#profile, { recursive: true, force: true, maxRetries: 5 });
  }
}

function colours(pixels) {
  const found = new Set();
  for (let i = 0; i < pixels.length; i += 4) found.add(pixels.readUInt32LE(i));
  return found.size;
}
/** Red pixels: arrows. */
function red(pixels) {
  let count = 0;
  for (let i = 0; i < pixels.length; i += 4) {
    if (pixels[i] > 150 && pixels[i + 1] < 120 && pixels[i + 2] < 100) ++count;
  }
  return count;
}
/** Pixels that two images differ in. */
function difference(a, b) {
  assert.equal(a.length, b.length);
  let count = 0;
  for (let i = 0; i < a.length; i += 4) {
    if (a[i] !== b[i] || a[i + 1] !== b[i + 1] || a[i + 2] !== b[i + 2]) ++count;
  }
  return count;
}

const report = await validator.validateBytes(new Uint8Array(readFileSync(`${name}.glb`)));
console.log(`validator: ${report.issues.numErrors} errors, ${report.issues.numWarnings} warnings`);
assert.equal(report.issues.numErrors, 0, JSON.stringify(report.issues.messages));
assert.equal(report.issues.numWarnings, 0, JSON.stringify(report.issues.messages));

const page = await Page.open(`${name}.html`);
await page.until("document.body?.dataset.ready === 'yes'");
await page.drawn();
const start = await page.pixels();
assert.ok(colours(start) > 50, 'the canvas shows something');
assert.equal(red(start), 0, 'nothing is touched yet');

// Held up after 3 s: elsewhere, and with arrows.
await page.setTime(3);
const held = await page.pixels();
console.log(`pixels: ${difference(start, held)} of ${held.length / 4} differ, ${red(held)} of arrows`);
assert.ok(difference(start, held) > 5000, 'the part has moved');
assert.ok(red(held) > 100, 'forces are seen');
assert.equal(await page.text('clock'), '3.000 s');
await page.picture(`${name}.png`);
// Back at the start it looks as it did.
await page.setTime(0);
assert.equal(difference(start, await page.pixels()), 0);

// What is picked says where it is, at each time.
await page.setTime(3);
const { x, y } = await page.evaluate(`(() => { const c = document.getElementById('canvas').getBoundingClientRect();
  return { x: c.x + c.width / 2, y: c.y + c.height / 2 }; })()`);
await page.click(10, 10);
assert.equal(await page.text('picked'), '', 'nothing is there');
const height = async () => Number((await page.text('picked')).match(/^part: \(\S+, \S+, (\S+)\) mm/)?.[1]);
for (let dy = 0; Number.isNaN(await height()) && dy < y; dy += 8) await page.click(x, y - dy);
const high = await height();
await page.setTime(0);
const low = await height();
console.log(`picked: the part, ${low} mm high at the start and ${high} mm in the hand`);
assert.ok(Math.abs(high - low - 120) < 1, 'lifted by 120 mm, less the sag');
await page.setTime(3);

// An arrow says its force: of 20 N on 60 sensors, with the weight.
const pixel = held.findIndex((_, i) => i % 4 === 0 && held[i] > 150 && held[i + 1] < 120 && held[i + 2] < 100) / 4;
const canvas = await page.evaluate("({ width: document.getElementById('canvas').width })");
await page.click((pixel % canvas.width) + 1, Math.floor(pixel / canvas.width) + 1);
console.log(`picked: ${await page.text('picked')}`);
const newtons = Number((await page.text('picked')).match(/^(?:first|second) pad \d+: .* mm, (\S+) N$/)?.[1]);
assert.ok(Math.abs(newtons - 20 / 60) < 0.2, 'an arrow and its force');

// It plays, and stops when told to.
await page.evaluate("document.getElementById('play').click()");
await page.until("Number(document.getElementById('time').value) > 3.2");
await page.evaluate("document.getElementById('play').click()");
const stopped = await page.text('clock');
await page.drawn();
assert.equal(await page.text('clock'), stopped);
assert.deepEqual(page.errors, []);
await page.close();

// A page whose recording is cut short says so.
const whole = readFileSync(`${name}.html`, 'utf8');
writeFileSync('cut.html', whole.replace(/(<script id="recording"[^>]*>.{4000})[^<]*/, '$1'));
const cut = await Page.open('cut.html');
await cut.until("document.getElementById('error') && !document.getElementById('error').hidden");
console.log(`cut short: ${await cut.text('error')}`);
assert.match(await cut.text('error'), /cannot be read/);
await cut.close();
