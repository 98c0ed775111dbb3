// Makes one page of a recording, which needs nothing else and no network:
//   node make_page.mjs RECORDING.glb PAGE.html
// Needs the packages of package.json beside it, or where NODE_PATH says.
// SPDX-License-Identifier: BSD-3-Clause
import { readFileSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { createRequire } from 'node:module';
import { gzipSync } from 'node:zlib';

const here = dirname(fileURLToPath(import.meta.url));
const packages = process.env.NODE_PATH ?? join(here, 'node_modules');
const esbuild = createRequire(join(packages, 'x.js'))('esbuild');

function fail(message) {
  console.error(`make_page: ${message}`);
  process.exit(1);
}

const [from, to] = process.argv.slice(2);
if (!to) fail('usage: node make_page.mjs RECORDING.glb PAGE.html');
let recording;
try {
  recording = readFileSync(from);
} catch (error) {
  fail(`${from}: ${error.message}`);
}
if (recording.length < 20 || recording.toString('latin1', 0, 4) !== 'glTF') fail(`${from}: must be a .glb file`);
if (recording.readUInt32LE(8) !== recording.length) {
  fail(`${from}: must have ${recording.readUInt32LE(8)} bytes, and has ${recording.length}: it is cut short, or has more after its end`);
}

const bundle = esbuild.buildSync({
  entryPoints: [join(here, 'viewer.js')],
  bundle: true,
  minify: true,
  format: 'esm',
  legalComments: 'inline',
  nodePaths: [packages],
  write: false,
}).outputFiles[0].text;
// A script ends at the first closing tag, wherever it stands.
const script = bundle.replaceAll('</script', '<\\/script');
const page = readFileSync(join(here, 'page.html'), 'utf8')
  .replace('VIEWER', () => script)
  .replace('RECORDING', () => gzipSync(recording, { level: 9 }).toString('base64'));
writeFileSync(to, page);
