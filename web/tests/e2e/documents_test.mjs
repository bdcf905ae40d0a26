// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// Usage: node documents_test.mjs MORGAGNI DOCUMENT_CASE_MAKER WEB_ROOT SCRATCH
// The documents of a case, judged by programs that know nothing of ours: the Khronos validator,
// three.js, poppler, qpdf, and a real Chromium that opens the viewer from disk without network.

import assert from 'node:assert/strict';
import { execFileSync, spawn, spawnSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { existsSync, mkdirSync, readFileSync, readdirSync, rmSync, statSync, writeFileSync } from 'node:fs';
import { dirname, join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import validator from 'gltf-validator';
import { PLYLoader } from 'three/examples/jsm/loaders/PLYLoader.js';
import { STLLoader } from 'three/examples/jsm/loaders/STLLoader.js';

import { LivePage } from './live_page.mjs';

const [program, maker, webRoot, scratch] = process.argv.slice(2);
rmSync(scratch, { recursive: true, force: true });
mkdirSync(scratch, { recursive: true });
const folder = join(scratch, 'case');
const out = join(scratch, 'documents');
execFileSync(maker, [folder]);
const command = ['document', '--case', folder, '--web', webRoot, '--output'];
execFileSync(program, [...command, out, '--author', 'Jane Roe'], { stdio: ['ignore', 'inherit', 'ignore'] });
const read = (name) => readFileSync(join(out, name));
const sha256 = (bytes) => createHash('sha256').update(bytes).digest('hex');
const arrayBuffer = (bytes) => bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);

async function checkGlb() {
  const report = await validator.validateBytes(new Uint8Array(read('model.glb')));
  assert.equal(report.issues.numErrors, 0, JSON.stringify(report.issues.messages.slice(0, 5)));
  assert.equal(report.issues.numWarnings, 0, JSON.stringify(report.issues.messages.slice(0, 5)));
  assert.equal(report.info.hasTextures, true);
}

function checkManifest() {
  const manifest = JSON.parse(read('manifest.json'));
  assert.equal(manifest.author, 'Jane Roe');
  assert.equal(manifest.findings, 4);
  const names = manifest.files.map(({ name }) => name);
  for (const name of ['model.glb', 'model.obj', 'skin.png', 'skin.ply', 'skin.stl', 'skin-print.stl',
    'skin-print.3mf', 'structures.3mf', 'viewer.html', 'report.pdf']) {
    assert.ok(names.includes(name), `${name} is missing`);
  }
  for (const { name, bytes, sha256: hash } of manifest.files) {
    assert.equal(sha256(read(name)), hash, name);
    assert.equal(statSync(join(out, name)).size, bytes, name);
  }
  for (const { name, sha256: hash } of manifest.case_files) {
    assert.equal(sha256(readFileSync(join(folder, name))), hash, name);
  }
  assert.ok(manifest.case_files.some(({ name }) => name === 'findings/findings.json'));
  return manifest;
}

/** As three.js reads them: the PLY's skin, finer, and the STL's are one surface. */
function skinBoxes() {
  const ply = new PLYLoader().parse(arrayBuffer(read('skin.ply')));
  const stl = new STLLoader().parse(arrayBuffer(read('skin.stl')));
  ply.computeBoundingBox();
  stl.computeBoundingBox();
  for (const end of ['min', 'max']) {
    assert.ok(ply.boundingBox[end].distanceTo(stl.boundingBox[end]) < 0.01, 'PLY and STL differ');
  }
  assert.ok(ply.getAttribute('color').count > 20000);
  return ply.boundingBox;
}

function checkReport(manifest) {
  const pdf = join(out, 'report.pdf');
  execFileSync('qpdf', ['--check', pdf], { stdio: 'ignore' });
  const info = execFileSync('pdfinfo', [pdf], { encoding: 'utf8' });
  const pages = Number(/Pages:\s+(\d+)/.exec(info)[1]);
  assert.ok(pages >= 4, info);
  assert.match(info, /JavaScript:\s+no/);
  const text = execFileSync('pdftotext', ['-layout', pdf, '-'], { encoding: 'utf8' });
  for (const words of ['not a medical device', 'Jane Roe', 'входное отверстие', '射入口', 'over the skin',
    '</script><script>', '± 1.9 mm (95 %)', 'uncertainty not known', `Page ${pages} of ${pages}`,
    manifest.files.find(({ name }) => name === 'model.glb').sha256,
    manifest.case_files.find(({ name }) => name === 'skin.ply').sha256]) {
    assert.ok(text.includes(words), `the report does not say "${words}"`);
  }
  const fonts = execFileSync('pdffonts', [pdf], { encoding: 'utf8' }).trim().split('\n').slice(2);
  assert.ok(fonts.length >= 3 && fonts.every((line) => /\byes yes\b|\byes\s+(yes|no)\s+(yes|no)\b/.test(line)),
    'a font is not embedded');
}

/** What stands on the canvas, as the page's own screen has it. */
function canvasOf(page) {
  return page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => {
    const source = document.querySelector('canvas');
    const copy = document.createElement('canvas');
    copy.width = 320;
    copy.height = 240;
    const context = copy.getContext('2d');
    context.drawImage(source, 0, 0, copy.width, copy.height);
    done([...context.getImageData(0, 0, copy.width, copy.height).data]);
  }))));
}

const isBody = (pixels, i) => Math.abs(pixels[i] - 14) + Math.abs(pixels[i + 1] - 18) + Math.abs(pixels[i + 2] - 22) > 30;

function share(pixels, test) {
  let count = 0;
  for (let i = 0; i < pixels.length; i += 4) count += test(pixels, i) ? 1 : 0;
  return (count * 4) / pixels.length;
}

const changed = (a, b) => share(a, (pixels, i) =>
  Math.abs(pixels[i] - b[i]) + Math.abs(pixels[i + 1] - b[i + 1]) + Math.abs(pixels[i + 2] - b[i + 2]) > 40);

async function openViewer(size) {
  const live = await LivePage.open('about:blank', size);
  const asked = [];
  await live.context.setOffline(true);
  live.page.on('request', (request) => asked.push(request.url()));
  await live.page.goto(pathToFileURL(resolve(out, 'viewer.html')).href);
  await live.page.waitForSelector('#viewer[data-ready]', { timeout: 60000 });
  await live.page.waitForTimeout(800);
  return { live, page: live.page, asked };
}

async function checkViewer(box) {
  assert.ok(statSync(join(out, 'viewer.html')).size < 25e6);
  const { live, page, asked } = await openViewer({ width: 1180, height: 820 });
  const front = await canvasOf(page);
  await page.screenshot({ path: join(scratch, 'viewer.png') });
  const body = share(front, isBody);
  assert.ok(body > 0.1 && body < 0.8, `the body fills ${body} of the picture`);
  // The painted skin, not the grey of what was never seen: skin has more red than blue.
  assert.ok(share(front, (p, i) => isBody(p, i) && p[i] > p[i + 2] + 20) > 0.8 * body);
  assert.equal(await page.textContent('.letter.at-left'), 'R');
  assert.equal(await page.textContent('.letter.at-top'), 'H');

  assert.deepEqual(await page.$$eval('.pin span:not(.end)', (pins) => pins.map((pin) => pin.textContent)),
    ['F1', 'F2', 'F3', 'F4']);
  assert.equal(await page.$$eval('.pin:not(.behind)', (pins) => pins.length), 6);
  assert.match(await page.textContent('.finding[data-id=F1] .note'), /^<\/script><script>/);
  assert.match(await page.textContent('.finding[data-id=F2]'), /± 1\.9 mm/);
  await page.click('.finding[data-id=F1]');
  await page.waitForTimeout(900);
  assert.ok(changed(front, await canvasOf(page)) > 0.02, 'the view does not go to the finding');

  await page.click('text=Front');
  await page.waitForTimeout(900);
  assert.ok(changed(front, await canvasOf(page)) < 0.01, 'Front is not where it began');
  await page.click('.part[data-plane=axial] button');
  await page.waitForTimeout(900);
  const slice = await canvasOf(page);
  assert.ok(changed(front, slice) > 0.02, 'the slice does not cut the body open');
  await page.$eval('.part[data-plane=axial] input', (input) => {
    input.value = '0.7';
    input.dispatchEvent(new Event('input'));
  });
  assert.ok(changed(slice, await canvasOf(page)) > 0.02, 'the slice does not move');
  await page.screenshot({ path: join(scratch, 'viewer-slice.png') });
  await page.click('.part[data-plane=axial] button');

  await page.click('.part[data-name=skin] button');
  const bones = await canvasOf(page);
  assert.ok(share(bones, isBody) > 0.005 && share(bones, isBody) < 0.8 * body, 'no bones without skin');

  // The page's own reading of the GLB lies where three.js finds the PLY.
  const shown = await page.evaluate(() => window.morgagni.box);
  for (const end of ['min', 'max']) {
    for (const axis of ['x', 'y', 'z']) assert.ok(Math.abs(shown[end][axis] - box[end][axis]) < 0.01);
  }
  assert.equal(await page.evaluate(() => window.hacked), undefined, 'a note was run');
  assert.equal(await page.evaluate(() => document.querySelectorAll('.note *').length), 0);
  const outside = asked.filter((url) => !/^(file|blob|data):/.test(url));
  assert.deepEqual(outside, []);
  assert.deepEqual(live.errors, []);
  await live.close();
}

async function checkUpright() {
  const { live, page } = await openViewer({ width: 820, height: 1180 });
  const wide = await page.evaluate(() => document.documentElement.scrollWidth);
  assert.ok(wide <= 820, `the page is ${wide} px wide`);
  assert.ok(share(await canvasOf(page), isBody) > 0.1);
  await page.screenshot({ path: join(scratch, 'viewer-upright.png') });
  await live.close();
}

const leftovers = (where) => readdirSync(where).filter((name) => name.includes('.part'));

function checkRefusals() {
  const run = (output, extra = []) =>
    spawnSync(program, [...command, output, ...extra], { encoding: 'utf8' });
  const pictures = join(scratch, 'pictures');
  mkdirSync(pictures);
  writeFileSync(join(pictures, 'holiday.jpg'), '');
  const foreign = run(pictures);
  assert.equal(foreign.status, 1);
  assert.match(foreign.stderr, /exists and holds no documents/);
  assert.deepEqual(readdirSync(pictures), ['holiday.jpg']);
  assert.match(run('/proc/nowhere/documents').stderr, /cannot be written/);
  assert.match(run(join(scratch, 'x'), ['--formats', 'docx']).stderr, /must be of glb, obj, .*"docx"/);
  assert.match(run(join(scratch, 'x'), ['--print', 'shell', '--wall-mm', '50']).stderr, /0.5 to 20, got 50/);
  const unbuilt = spawnSync(program, ['document', '--case', folder, '--web', scratch, '--output', join(scratch, 'x')],
    { encoding: 'utf8' });
  assert.match(unbuilt.stderr, /viewer page is not built/);
  assert.ok(!existsSync(join(scratch, 'x')));

  // A disk that takes no more: the older documents stay whole, and nothing else is left.
  const before = sha256(read('manifest.json'));
  const full = spawnSync('bash', ['-c', 'trap "" XFSZ; ulimit -f 200; exec "$@"', 'bash', program, ...command, out],
    { encoding: 'utf8' });
  assert.equal(full.status, 1);
  assert.match(full.stderr, /could not be written: File too large/);
  assert.equal(sha256(read('manifest.json')), before);
  assert.deepEqual(leftovers(dirname(out)), []);
}

async function checkStop() {
  const where = join(scratch, 'stopped');
  const process_ = spawn(program, [...command, where], { stdio: ['ignore', 'ignore', 'pipe'] });
  let words = '';
  process_.stderr.on('data', (text) => {
    if (words === '') process_.kill('SIGINT');
    words += text;
  });
  const code = await new Promise((done) => process_.on('exit', done));
  assert.equal(code, 1);
  assert.match(words, /stopped: no documents were made/);
  assert.ok(!existsSync(where));
  assert.deepEqual(leftovers(scratch), []);
}

await checkGlb();
const manifest = checkManifest();
const box = skinBoxes();
checkReport(manifest);
await checkViewer(box);
await checkUpright();
checkRefusals();
await checkStop();
console.log('the documents are what they say, and open without network');
