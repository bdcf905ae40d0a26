// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// A pretended range camera that pushes through the stock Foxglove client and message writers.

import { parse } from '@foxglove/rosmsg';
import { MessageWriter } from '@foxglove/rosmsg2-serialization';
import foxglove from '@foxglove/ws-protocol';
import WebSocket from 'ws';

const { FoxgloveClient } = foxglove;

const HEADER = `std_msgs/Header header
${'='.repeat(80)}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
${'='.repeat(80)}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
`;
const after_header = (fields, more = '') => HEADER.replace('header\n', `header\n${fields}`) + more;
const part = (name, fields) => `${'='.repeat(80)}\nMSG: ${name}\n${fields}`;

const SCHEMAS = {
  'sensor_msgs/msg/Image': after_header(
    'uint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\nuint8[] data\n'),
  'sensor_msgs/msg/CompressedImage': after_header('string format\nuint8[] data\n'),
  'sensor_msgs/msg/CameraInfo': after_header(
    'uint32 height\nuint32 width\nstring distortion_model\nfloat64[] d\nfloat64[9] k\nfloat64[9] r\n' +
      'float64[12] p\nuint32 binning_x\nuint32 binning_y\nsensor_msgs/RegionOfInterest roi\n',
    part('sensor_msgs/RegionOfInterest',
      'uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n')),
  'tf2_msgs/msg/TFMessage':
    'geometry_msgs/TransformStamped[] transforms\n' +
    part('geometry_msgs/TransformStamped',
      'std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n') +
    part('geometry_msgs/Transform', 'geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n') +
    part('geometry_msgs/Vector3', 'float64 x\nfloat64 y\nfloat64 z\n') +
    part('geometry_msgs/Quaternion', 'float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n') +
    HEADER.slice(HEADER.indexOf('=')),
};

export const stamp_of = (ns) => ({ sec: Number(ns / 1000000000n), nanosec: Number(ns % 1000000000n) });
export const wall_ns = () => BigInt(Date.now()) * 1000000n;

/** The message as CDR bytes. */
export function cdr(schemaName, message) {
  return new MessageWriter(parse(SCHEMAS[schemaName], { ros2: true })).writeMessage(message);
}

/** A client that has met the server; `statuses` is all that it was told. */
export class Device {
  /** @param {string} address @param {{protocol?: string, options?: object}} [how] */
  static async connect(address, { protocol = 'foxglove.websocket.v1', options = {} } = {}) {
    const socket = new WebSocket(address, [protocol], options);
    const client = new FoxgloveClient({ ws: socket });
    const device = new Device(client, socket);
    await new Promise((resolve, reject) => {
      client.on('serverInfo', (info) => {
        device.info = info;
        resolve();
      });
      client.on('error', reject);
    });
    return device;
  }

  constructor(client, socket) {
    this.client = client;
    this.socket = socket;
    this.statuses = [];
    this.channels = new Map();
    this.closed = new Promise((resolve) => client.on('close', resolve));
    client.on('status', (status) => this.statuses.push(status));
  }

  /** @param {'cdr'|'json'} [encoding] */
  publish(topic, schemaName, message, encoding = 'cdr') {
    if (!this.channels.has(topic)) {
      this.channels.set(topic, this.client.advertise({ topic, encoding, schemaName }));
    }
    const bytes = encoding === 'cdr' ? cdr(schemaName, message) : Buffer.from(JSON.stringify(message));
    this.client.sendMessage(this.channels.get(topic), bytes);
  }

  /** Waits until the server has said something with `text` in it. */
  async told(text, timeout_ms = 5000) {
    const until = Date.now() + timeout_ms;
    while (Date.now() < until) {
      const found = this.statuses.find((status) => status.message.includes(text));
      if (found) return found;
      await new Promise((resolve) => setTimeout(resolve, 10));
    }
    throw new Error(`never told "${text}", only ${JSON.stringify(this.statuses)}`);
  }

  /** Gone without a word, as when the cable is pulled. */
  vanish() {
    this.socket.terminate();
  }

  close() {
    this.client.close();
    return this.closed;
  }
}

/** @param {{width: number, height: number, fx: number, fy: number, cx: number, cy: number, distortion?: number[]}} pinhole */
export function camera_info(pinhole, frame_id, ns) {
  const { width, height, fx, fy, cx, cy, distortion = [0, 0, 0, 0, 0] } = pinhole;
  return {
    header: { stamp: stamp_of(ns), frame_id },
    height,
    width,
    distortion_model: 'plumb_bob',
    d: distortion,
    k: [fx, 0, cx, 0, fy, cy, 0, 0, 1],
    r: [1, 0, 0, 0, 1, 0, 0, 0, 1],
    p: [fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0],
    binning_x: 0,
    binning_y: 0,
    roi: { x_offset: 0, y_offset: 0, height: 0, width: 0, do_rectify: false },
  };
}

export function transform(parent, child, translation, rotation = { x: 0, y: 0, z: 0, w: 1 }) {
  return {
    transforms: [
      { header: { stamp: stamp_of(0n), frame_id: parent }, child_frame_id: child, transform: { translation, rotation } },
    ],
  };
}
