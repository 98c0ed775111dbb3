// A page in a headless browser, and the looks at its pixels.
// SPDX-License-Identifier: BSD-3-Clause
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

/** A page in a browser, spoken to by the DevTools protocol over a pipe. */
export class Page {
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
        '--remote-debugging-pipe', '--window-size=1280,760', `--user-data-dir=${page.#profile}`],
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
    if (file !== 'about:blank') await page.go(file);
    return page;
  }
  async go(file) {
    await this.send('Page.navigate', { url: pathToFileURL(resolve(file)).href });
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
  async pixels(selector = '#canvas') {
    const text = await this.evaluate(`(() => { const from = document.querySelector('${selector}');
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
  /** A click on a pixel of the canvas of the scene. */
  async clickPixel(pixel) {
    const { width, x, y } = await this.evaluate(`(() => { const c = document.getElementById('canvas');
      const { x, y } = c.getBoundingClientRect(); return { width: c.width, x, y }; })()`);
    await this.click(x + (pixel % width) + 0.5, y + Math.floor(pixel / width) + 0.5);
  }
  /** Middle of an element, in pixels of the page. */
  middleOf(selector) {
    return this.evaluate(`(() => { const e = document.querySelector('${selector}'); e.scrollIntoView({ block: 'center' });
      const { x, y, width, height } = e.getBoundingClientRect(); return { x: x + width / 2, y: y + height / 2, width, height }; })()`);
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

export function colours(pixels) {
  const found = new Set();
  for (let i = 0; i < pixels.length; i += 4) found.add(pixels.readUInt32LE(i));
  return found.size;
}
/** Pixels whose colour is taken for `is(red, green, blue)`: how many, and the middle of the first three beside each other. */
export function find(pixels, is) {
  let count = 0;
  let first = -1;
  let run = 0;
  for (let i = 0; i < pixels.length; i += 4) {
    run = is(pixels[i], pixels[i + 1], pixels[i + 2]) ? run + 1 : 0;
    if (run === 0) continue;
    // A pixel at the border of a thing may be a click beside it.
    if (first < 0 && run === 3) first = i / 4 - 1;
    ++count;
  }
  return { count, first };
}
/** Colours of the page's things (examples/replay/colours.js). */
const isNear = (r, g, b, [x, y, z]) => Math.abs(r - x) + Math.abs(g - y) + Math.abs(b - z) < 12;
export const isForce = (r, g, b) => isNear(r, g, b, [204, 26, 26]);
export const isContact = (r, g, b) => isNear(r, g, b, [20, 120, 60]);
export const isSlipping = (r, g, b) => isNear(r, g, b, [240, 140, 0]);
export const isFree = (r, g, b) => isNear(r, g, b, [150, 155, 160]);
/** Between the colours of a shallow and of a deep touch, and not the scene's. */
export function isStuck(r, g, b) {
  const x = (158 - r) / 150;
  return x >= 0 && x <= 1 && isNear(r, g, b, [158 - 150 * x, 202 - 133 * x, 225 - 77 * x]);
}
/** Pixels that two images differ in. */
export function difference(a, b) {
  assert.equal(a.length, b.length);
  let count = 0;
  for (let i = 0; i < a.length; i += 4) {
    if (a[i] !== b[i] || a[i + 1] !== b[i + 1] || a[i + 2] !== b[i + 2]) ++count;
  }
  return count;
}
