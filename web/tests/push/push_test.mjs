// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// Pushes to `morgagni record --camera push:` with the stock Foxglove client, with examples/push_realsense.py and
// push_azure_kinect.py around pretended cameras, and as somebody hostile would; what was recorded is read with @mcap/core.
// Usage: push_test.mjs MORGAGNI

import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { mkdirSync, mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { connect } from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { createInterface } from 'node:readline';

import { parse } from '@foxglove/rosmsg';
import { MessageReader } from '@foxglove/rosmsg2-serialization';
import { McapIndexedReader } from '@mcap/core';
import { decompress } from 'fzstd';
import WebSocket from 'ws';

import { camera_info, Device, stamp_of, transform, wall_ns } from './device.mjs';
import { decodeRvl, encodeRvl } from './rvl.mjs';

const [program] = process.argv.slice(2);
const scratch = mkdtempSync(join(tmpdir(), 'mor_push_'));
const DEPTH = { width: 64, height: 48, fx: 58.5, fy: 58.25, cx: 31.5, cy: 23.5, distortion: [0.1, -0.2, 0.001, 0.002, 0.05] };
const COLOR = { width: 80, height: 60, fx: 77.5, fy: 77.25, cx: 39.5, cy: 29.5 };
const DEPTH_TOPIC = '/camera/depth/image_raw';
const COLOR_TOPIC = '/camera/color/image_raw';
const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

/** `morgagni record` from push:, until it has its frames. */
class Recording {
  static async start(name, camera, frames, environment = {}) {
    const recording = new Recording();
    recording.path = join(scratch, `${name}.mcap`);
    const parameters = ['record', '--camera', camera, '--out', recording.path, '--color', 'lossless'];
    recording.process = spawn(program, [...parameters, '--frames', `${frames}`],
      { stdio: ['ignore', 'pipe', 'pipe'], env: { ...process.env, ...environment } });
    recording.log = [];
    recording.ended = once(recording.process, 'exit');
    const read = (line) => recording.log.push(line);
    createInterface(recording.process.stderr).on('line', read);
    createInterface(recording.process.stdout).on('line', read);
    const line = await recording.says('listening at');
    recording.address = /wss?:\/\/\S+/.exec(line)[0];
    recording.port = Number(/:(\d+)$/.exec(recording.address)[1]);
    return recording;
  }
  async says(text, timeout_ms = 30000) {
    const until = Date.now() + timeout_ms;
    while (Date.now() < until) {
      const found = this.log.find((line) => line.includes(text));
      if (found) return found;
      await sleep(10);
    }
    throw new Error(`morgagni never said "${text}":\n${this.log.join('\n')}`);
  }
  async end() {
    const [code] = await this.ended;
    assert.equal(code, 0, this.log.join('\n'));
    return readMcap(readFileSync(this.path));
  }
  async stop() {
    this.process.kill('SIGTERM');
    await this.ended;
  }
  files() {
    return readdirSync(`/proc/${this.process.pid}/fd`).length;
  }
  memory_kib() {
    return Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${this.process.pid}/status`, 'utf8'))[1]);
  }
}

async function readMcap(bytes) {
  const readable = { size: async () => BigInt(bytes.length), read: async (at, n) => new Uint8Array(bytes.subarray(Number(at), Number(at + n))) };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers: { zstd: (packed, size) => decompress(packed, new Uint8Array(Number(size))) } });
  const byTopic = {};
  for await (const message of reader.readMessages()) {
    const channel = reader.channelsById.get(message.channelId);
    const schema = new TextDecoder().decode(reader.schemasById.get(channel.schemaId).data);
    (byTopic[channel.topic] ??= []).push(new MessageReader(parse(schema, { ros2: true })).readMessage(message.data));
  }
  for await (const attachment of reader.readAttachments()) byTopic.calibration = JSON.parse(new TextDecoder().decode(attachment.data));
  return byTopic;
}

const depthPixels = (id) => Uint16Array.from({ length: DEPTH.width * DEPTH.height },
  (_, i) => ((i >> 4) % 7 === 0 ? 0 : 600 + ((i * 37 + id * 11) % 3000)));
const bytesOf = (typed) => new Uint8Array(typed.buffer, typed.byteOffset, typed.byteLength);
const colorPixels = (id) => Uint8Array.from({ length: COLOR.width * COLOR.height * 3 }, (_, i) => (i * 7 + id) % 251);

function describe(device, encoding = 'cdr') {
  device.publish('/camera/depth/camera_info', 'sensor_msgs/msg/CameraInfo', camera_info(DEPTH, 'depth', wall_ns()), encoding);
  device.publish('/camera/color/camera_info', 'sensor_msgs/msg/CameraInfo', camera_info(COLOR, 'color', wall_ns()), encoding);
  device.publish('/tf_static', 'tf2_msgs/msg/TFMessage', transform('color', 'depth', { x: -0.025, y: 0, z: 0.001 }), encoding);
}
function pushColor(device, ns, id) {
  device.publish(COLOR_TOPIC, 'sensor_msgs/msg/Image', { header: { stamp: stamp_of(ns), frame_id: 'color' },
    height: COLOR.height, width: COLOR.width, encoding: 'rgb8', is_bigendian: 0, step: COLOR.width * 3, data: colorPixels(id) });
}
function pushPlainDepth(device, ns, id, change = {}) {
  device.publish(DEPTH_TOPIC, 'sensor_msgs/msg/Image', { header: { stamp: stamp_of(ns), frame_id: 'depth' },
    height: DEPTH.height, width: DEPTH.width, encoding: '16UC1', is_bigendian: 0, step: DEPTH.width * 2,
    data: bytesOf(depthPixels(id)), ...change });
}
function pushRvl(device, ns, id) {
  const packed = encodeRvl(depthPixels(id));
  const data = new Uint8Array(12 + 8 + packed.length);
  new DataView(data.buffer).setUint32(12, DEPTH.width, true);
  new DataView(data.buffer).setUint32(16, DEPTH.height, true);
  data.set(packed, 20);
  device.publish(`${DEPTH_TOPIC}/compressedDepth`, 'sensor_msgs/msg/CompressedImage',
    { header: { stamp: stamp_of(ns), frame_id: 'depth' }, format: '16UC1; compressedDepth rvl', data });
}
/** Frames until the other side has enough. */
async function keepPushing(device, pushDepth, isDone) {
  for (let id = 0; !isDone(); id = (id + 1) % 5) {
    const ns = wall_ns();
    pushDepth(device, ns, id);
    pushColor(device, ns + 3000000n, id);
    await sleep(30);
  }
}
async function pushUntilEnd(device, pushDepth, recording) {
  let done = false;
  recording.ended.then(() => (done = true));
  await keepPushing(device, pushDepth, () => done);
}

/** Depth and colour came through to the last bit, and belong together. */
function checkFrames(recorded, count) {
  const depths = recorded['/camera/depth/image_raw'];
  assert.equal(depths.length, count);
  for (const depth of depths) {
    const pixels = new Uint16Array(depth.data.slice().buffer);
    const id = [0, 1, 2, 3, 4].find((each) => Buffer.compare(bytesOf(depthPixels(each)), bytesOf(pixels)) === 0);
    assert.ok(id !== undefined, 'a depth picture that was never sent');
  }
  assert.deepEqual(recorded.calibration.depth, { ...DEPTH, distortion: DEPTH.distortion });
  assert.equal(recorded.calibration.color.fx, COLOR.fx);
  assert.deepEqual(recorded.calibration.color_from_depth, [[1, 0, 0, -25], [0, 1, 0, 0], [0, 0, 1, 1]]);
}

async function testStockClient() {
  const sample = depthPixels(3);
  assert.deepEqual(decodeRvl(encodeRvl(sample), sample.length), sample, 'the test’s own RVL');
  for (const [name, push, protocol] of [['plain', pushPlainDepth, 'foxglove.websocket.v1'], ['rvl', pushRvl, 'foxglove.sdk.v1']]) {
    const recording = await Recording.start(name, 'push:0', 6);
    assert.ok(recording.address.startsWith('ws://127.0.0.1:'), 'not beyond this machine unless asked');
    const device = await Device.connect(recording.address, { protocol });
    assert.deepEqual(device.info.capabilities, ['clientPublish']);
    assert.deepEqual(device.info.supportedEncodings, ['cdr', 'json']);
    assert.equal(device.socket.protocol, protocol);
    describe(device, name === 'rvl' ? 'json' : 'cdr');
    await pushUntilEnd(device, push, recording);
    const recorded = await recording.end();
    checkFrames(recorded, 6);
    const clocks = recorded['/camera/clock'].map(({ time_ref }) => time_ref.sec);
    assert.ok(Math.abs(clocks[0] - Date.now() / 1000) < 60, 'the device’s clock is kept');
    assert.deepEqual(device.statuses, []);
  }
}

/** What is recorded of an example around its pretended camera. */
async function recordExample(name) {
  const recording = await Recording.start(name, 'push:0', 4);
  const python = spawn('/usr/bin/python3', [`examples/push_${name}.py`, recording.address],
    { env: { ...process.env, PYTHONPATH: 'web/tests/push/fake' }, stdio: ['ignore', 'inherit', 'pipe'] });
  const complaints = [];
  createInterface(python.stderr).on('line', (line) => complaints.push(line));
  const recorded = await Promise.race([recording.end(), sleep(60000)]);
  python.kill();
  assert.ok(recorded, `the example pushed nothing:\n${complaints.join('\n')}\n${recording.log.join('\n')}`);
  const pixels = new Uint16Array(recorded['/camera/depth/image_raw'][0].data.slice().buffer);
  assert.deepEqual([pixels[0], pixels[1], pixels.at(-1)], [0, 801, 801]);
  const { depth, color, color_from_depth } = recorded.calibration;
  const rows = color_from_depth.map((row) => row.map((value) => Math.round(value * 1e6) / 1e6 + 0));
  return { depth, color, rows };
}

async function testPythonExamples() {
  const realsense = await recordExample('realsense');
  assert.equal(realsense.depth.fy, 601.5);
  assert.equal(realsense.color.fx, 610.5);
  assert.deepEqual(realsense.rows, [[0, -1, 0, 15], [1, 0, 0, 0], [0, 0, 1, 1]]);
  const azure = await recordExample('azure_kinect');
  const none = [0, 0, 0, 0, 0];
  assert.deepEqual(azure.depth, { width: 640, height: 576, fx: 504.5, fy: 505.5, cx: 319.5, cy: 239.25, distortion: none });
  assert.deepEqual(azure.color, { width: 1280, height: 720, fx: 610.5, fy: 611.5, cx: 319.5, cy: 239.25, distortion: none });
  assert.deepEqual(azure.rows, [[0, -1, 0, -32], [1, 0, 0, -2], [0, 0, 1, 4]]);
}

/** What is kept of a device that says who it is takes the place of its own word. */
async function testKeptCalibration() {
  const cameras = join(scratch, 'cameras');
  const keep = (device_id) => {
    mkdirSync(join(cameras, device_id), { recursive: true });
    const calibration = { depth: { ...DEPTH, fx: 61.5 }, color: { ...COLOR, distortion: [0, 0, 0, 0, 0] },
      color_from_depth: [[1, 0, 0, -20], [0, 1, 0, 0], [0, 0, 1, 0]] };
    writeFileSync(join(cameras, device_id, '2026-01-31T10-00-00Z.json'), JSON.stringify(
      { device_id, made_at: '2026-01-31T10:00:00Z', made_by: 'board', figures: {},
        calibration: { ...calibration, origin: 'board, 2026-01-31T10:00:00Z' } }));
  };
  keep('push-bench');
  keep('mine');
  let number = 0;
  const seen = async (camera, suffix, advertised) => {
    const recording = await Recording.start(`kept${++number}`, camera, 2, { MORGAGNI_CAMERAS_DIR: cameras });
    const device = await Device.connect(recording.address + suffix);
    if (advertised) device.socket.send(JSON.stringify({ op: 'advertise', channels: [], device: advertised }));
    describe(device);
    await pushUntilEnd(device, pushPlainDepth, recording);
    const { calibration } = await recording.end();
    return [calibration.depth.fx, calibration.origin ?? ''];
  };
  const kept = [61.5, 'board, 2026-01-31T10:00:00Z'];
  assert.deepEqual(await seen('push:0', '/?device=bench'), kept, 'it says so in the address');
  assert.deepEqual(await seen('push:0', '', 'bench'), kept, 'it says so when it advertises');
  assert.deepEqual(await seen('push:0,device=mine', ''), kept, 'the user says so');
  assert.deepEqual(await seen('push:0', '/?device=other'), [DEPTH.fx, ''], 'of another nothing is kept');

  const recording = await Recording.start('nobody', 'push:0', 2);
  const device = await Device.connect(`${recording.address}/?device=..%2Fetc`);
  await device.told("'../etc' is no device's id");
  device.vanish();
  await recording.stop();
}

async function testWhatIsRefused() {
  const recording = await Recording.start('refused', 'push:0', 3);
  const { address, port } = recording;
  const refusal = (headers, path = '/') => new Promise((resolve) => {
    const socket = new WebSocket(address + path, ['foxglove.websocket.v1'], { headers });
    socket.on('unexpected-response', (_, response) => resolve(response.statusCode));
    socket.on('open', () => { socket.close(); resolve(101); });
    socket.on('error', () => {});
  });
  assert.equal(await refusal({ Origin: 'https://evil.example' }), 403, 'a page of another site');
  assert.equal(await refusal({ Origin: 'null' }), 403, 'a page that hides where it is from');
  assert.equal(await refusal({ Origin: 'http://localhost:8000' }), 101);
  assert.equal((await fetch(`http://127.0.0.1:${port}/`)).status, 426);

  const device = await Device.connect(address);
  device.socket.send('garbage');
  await device.told('JSON object');
  device.socket.send(JSON.stringify({ op: 'subscribe', subscriptions: [] }));
  await device.told("'subscribe' is not offered");
  device.socket.send(Buffer.from([1, 9, 0, 0, 0]));
  await device.told('channel 9 was not advertised');
  device.socket.send(Buffer.alloc(0));
  await device.told('binary message of 0 bytes');
  const pushBoth = (change) => {
    const ns = wall_ns();
    pushPlainDepth(device, ns, 0, change);
    pushColor(device, ns, 0);
  };
  pushBoth();
  await device.told('has no CameraInfo');
  const nan = camera_info({ ...DEPTH, fx: NaN }, 'depth', 0n);
  device.publish('/camera/depth/camera_info', 'sensor_msgs/msg/CameraInfo', nan);
  await device.told('not finite');
  describe(device);
  await sleep(50);
  pushBoth({ width: 32, step: 64 });
  await device.told('a picture of 32x48 px');
  await recording.says('cannot be used: a picture of 32x48 px');

  // One device at a time: a second is turned away while the first sends.
  let done = false;
  const pushing = keepPushing(device, pushPlainDepth, () => done);
  const second = await Device.connect(address);
  await second.told('another device is sending');
  assert.equal((await second.closed).code, 1008);
  await recording.ended;
  done = true;
  await pushing;
  checkFrames(await recording.end(), 3);
}

async function testToken() {
  const recording = await Recording.start('token', 'push:0,token=right-horse', 2);
  const tried = (suffix, options = {}) => Device.connect(recording.address + suffix, { options }).then(
    (device) => { device.vanish(); return 'in'; }, () => 'refused');
  assert.equal(await tried(''), 'refused');
  assert.equal(await tried('/?token=wrong-horse'), 'refused');
  assert.equal(await tried('/?token=right-hors'), 'refused');
  assert.equal(await tried('', { headers: { Authorization: 'Bearer right-horse' } }), 'in');
  await sleep(1100); // It may be missed a little later; for so long nobody else is let in.
  const device = await Device.connect(`${recording.address}/?token=right-horse`, { options: { headers: { Origin: 'https://other.example' } } });
  describe(device);
  await pushUntilEnd(device, pushPlainDepth, recording);
  checkFrames(await recording.end(), 2);
}

/** A device whose cable is pulled is missed within a second, and taken back within three. */
async function testVanishing() {
  const recording = await Recording.start('vanishing', 'push:0', 100000);
  let device = await Device.connect(recording.address);
  describe(device);
  let gone = false;
  const first = keepPushing(device, pushPlainDepth, () => gone);
  await sleep(1500);
  gone = true;
  await first;
  device.vanish();
  const pulled_at = Date.now();
  await recording.says('no device is connected: it must push to ws://', 5000);
  const said_ms = Date.now() - pulled_at;
  device = await Device.connect(recording.address);
  describe(device);
  gone = false;
  const again = keepPushing(device, pushPlainDepth, () => gone);
  await sleep(3000);
  // `record` warns each time that it gets no frame, each 0.7 s.
  const warnings = () => recording.log.filter((line) => line.includes('warning'));
  const before = warnings().length;
  await sleep(2000);
  assert.deepEqual(warnings().slice(before), [], 'frames have been back for long');
  gone = true;
  await again;
  device.vanish();
  await recording.stop();
  console.log(`said after ${said_ms} ms`);
  assert.ok(said_ms < 1000, `said after ${said_ms} ms`);
}

/** A device that comes, sends and is gone without a word, again and again, leaves nothing behind. */
async function testFiveHundredTimes() {
  const recording = await Recording.start('often', 'push:0', 100000);
  const threads = () => readdirSync(`/proc/${recording.process.pid}/task`).length;
  const once_there = async () => {
    for (;;) {
      const device = await Device.connect(recording.address);
      describe(device);
      const ns = wall_ns();
      pushPlainDepth(device, ns, 0);
      pushColor(device, ns, 0);
      await sleep(2);
      // Where the one before has not been missed yet, it is turned away and tries again.
      if (device.statuses.length === 0) return device.vanish();
      device.vanish();
      await sleep(50);
    }
  };
  for (let i = 0; i < 50; ++i) await once_there();
  const before = { files: recording.files(), threads: threads(), kib: recording.memory_kib() };
  for (let i = 0; i < 450; ++i) await once_there();
  await sleep(1000);
  const after = { files: recording.files(), threads: threads(), kib: recording.memory_kib() };
  console.log(`500 devices: ${JSON.stringify(before)} -> ${JSON.stringify(after)}`);
  assert.ok(after.files <= before.files && after.threads <= before.threads);
  assert.ok(after.kib - before.kib < 8192, 'memory grows');
  await recording.stop();
}

/** Many connections, half-open ones, too much in one message and in many parts: bounded, and still there after. */
async function testFlood() {
  const recording = await Recording.start('flood', 'push:0', 2);
  const before_kib = recording.memory_kib();
  const files = recording.files();
  const sockets = Array.from({ length: 60 }, () => connect(recording.port, '127.0.0.1').on('error', () => {}).resume());
  await sleep(2000);
  const kept = recording.files() - files;
  assert.ok(kept >= 1 && kept <= 16, `${kept} connections are kept`);
  for (const socket of sockets) socket.destroy();
  await sleep(300);

  const flood = await Device.connect(recording.address);
  flood.socket.on('error', () => {});
  flood.socket.send(Buffer.alloc(40 << 20));
  // "Too big", unless the connection broke while the rest was still on its way.
  assert.ok([1009, 1006].includes((await flood.closed).code), 'too big');

  const parts = new WebSocket(recording.address, ['foxglove.websocket.v1']);
  parts.on('error', () => {});
  await once(parts, 'open');
  let isClosed = false;
  const closed = once(parts, 'close').then(() => (isClosed = true));
  for (let i = 0; i < 20 && !isClosed; ++i) {
    const sent = new Promise((resolve) => parts.send(Buffer.alloc(16 << 20), { fin: false, binary: true }, resolve));
    await Promise.race([sent, closed]);
  }
  await sleep(200);
  const grown_mib = (recording.memory_kib() - before_kib) / 1024;
  console.log(`after 320 MiB in parts: closed ${isClosed}, memory grew by ${grown_mib.toFixed(0)} MiB`);
  assert.ok(grown_mib < 150, `memory grew by ${grown_mib} MiB`);
  parts.terminate();

  const talker = await Device.connect(recording.address);
  for (let i = 0; i < 400; ++i) talker.socket.send(`{"op":"nonsense ${i}"}`);
  assert.equal((await talker.closed).code, 1008, 'told too often');
  assert.ok(talker.statuses.length <= 210);

  const device = await Device.connect(recording.address);
  describe(device);
  await pushUntilEnd(device, pushPlainDepth, recording);
  checkFrames(await recording.end(), 2);
}

try {
  const tests = { testStockClient, testPythonExamples, testKeptCalibration, testWhatIsRefused, testToken, testVanishing, testFiveHundredTimes, testFlood };
  for (const [name, test] of Object.entries(tests)) {
    await Promise.race([test(), sleep(90000).then(() => Promise.reject(new Error(`${name} takes too long`)))]);
    console.log(`ok ${name}`);
  }
  process.exitCode = 0;
} finally {
  rmSync(scratch, { recursive: true, force: true });
}
process.exit();
