// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// A recording as others see it: read with @mcap/core and decoded with the packages that Foxglove
// decodes ROS 2 messages with; and the other way, written by @mcap/core and read by Morgagni.
// Usage: mcap_test.mjs SAMPLE_RECORDING (the program that writes and reads the sample)

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import { McapIndexedReader, McapStreamReader, McapWriter } from "@mcap/core";
import { decompress } from "fzstd";

const [sample] = process.argv.slice(2);
const folder = mkdtempSync(join(tmpdir(), "mor_mcap_"));
const decompressHandlers = { zstd: (packed, size) => decompress(packed, new Uint8Array(Number(size))) };

class Buffer8 {
  constructor(bytes) {
    this.bytes = bytes;
  }
  async size() {
    return BigInt(this.bytes.length);
  }
  async read(offset, length) {
    return new Uint8Array(this.bytes.subarray(Number(offset), Number(offset + length)));
  }
}

/** Reads by the summary and the indexes; the package checks every sum. */
async function readIndexed(bytes) {
  const reader = await McapIndexedReader.Initialize({ readable: new Buffer8(bytes), decompressHandlers });
  const decoders = new Map();
  for (const channel of reader.channelsById.values()) {
    const schema = reader.schemasById.get(channel.schemaId);
    assert.equal(channel.messageEncoding, "cdr");
    assert.equal(schema.encoding, "ros2msg");
    decoders.set(channel.id, new MessageReader(parse(new TextDecoder().decode(schema.data), { ros2: true })));
  }
  const byTopic = new Map();
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    const { topic } = reader.channelsById.get(message.channelId);
    if (!byTopic.has(topic)) byTopic.set(topic, []);
    byTopic.get(topic).push({ logTime: message.logTime, ...decoders.get(message.channelId).readMessage(message.data) });
  }
  return { reader, byTopic };
}

function near(a, b) {
  assert.ok(Math.abs(a - b) < 1e-12, `${a} is not ${b}`);
}

async function checkOurs(bytes) {
  const { reader, byTopic } = await readIndexed(bytes);
  assert.equal(reader.header.profile, "ros2");
  assert.match(reader.header.library, /^morgagni /);
  assert.equal(reader.statistics.attachmentCount, 1);
  let total = 0n;
  for (const count of reader.statistics.channelMessageCounts.values()) total += count;
  assert.equal(reader.statistics.messageCount, total);

  const depths = byTopic.get("/camera/depth/image_raw");
  assert.equal(depths.length, 12);
  depths.forEach((depth, id) => {
    assert.deepEqual([depth.width, depth.height, depth.encoding, depth.step], [32, 24, "16UC1", 64]);
    const pixels = new Uint16Array(depth.data.slice().buffer);
    assert.equal(pixels[7], 0);
    assert.equal(pixels[20], 600 + 97 * 20 + id);
    assert.equal(depth.header.frame_id, "depth");
    const stamp = BigInt(depth.header.stamp.sec) * 1000000000n + BigInt(depth.header.stamp.nsec ?? depth.header.stamp.nanosec);
    assert.equal(stamp, depth.logTime);
    assert.equal(depth.logTime - depths[0].logTime, BigInt(id) * 33333333n);
  });
  assert.ok(Math.abs(Number(depths[0].logTime) / 1e6 - Date.now()) < 60000, "stamps are wall time");

  const colors = byTopic.get("/camera/color/image_raw/compressed");
  assert.equal(colors.length, 12);
  assert.equal(colors[0].format, "png");
  assert.deepEqual([...colors[0].data.slice(1, 4)], [..."PNG"].map((c) => c.charCodeAt(0)));

  const info = byTopic.get("/camera/depth/camera_info")[0];
  assert.deepEqual([info.width, info.height, info.distortion_model], [32, 24, "plumb_bob"]);
  assert.deepEqual([...info.d], [0.1, -0.2, 0.001, 0.002, 0.05]);
  assert.deepEqual([...info.k], [29.3, 0, 15.7, 0, 29.1, 11.9, 0, 0, 1]);
  assert.deepEqual([...info.p], [29.3, 0, 15.7, 0, 0, 29.1, 11.9, 0, 0, 0, 1, 0]);
  assert.equal(info.roi.do_rectify, false);
  assert.equal(byTopic.get("/camera/color/camera_info")[0].width, 40);

  // Frame 1's pose: 0.2 rad about (3, -1, 2), metres in /tf.
  const { transforms } = byTopic.get("/tf")[1];
  assert.equal(transforms.length, 1);
  assert.deepEqual([transforms[0].header.frame_id, transforms[0].child_frame_id], ["ct", "depth"]);
  const { translation, rotation } = transforms[0].transform;
  near(translation.x, 1 / 3000);
  near(translation.y, -0.2007);
  near(translation.z, 0.9011);
  near(rotation.w, Math.cos(0.1));
  near(rotation.x, (Math.sin(0.1) * 3) / Math.sqrt(14));
  assert.equal(byTopic.get("/tf_static")[0].transforms[0].child_frame_id, "color");

  const states = byTopic.get("/diagnostics").map((message) => message.status[0]);
  assert.deepEqual(states.slice(0, 3).map((status) => status.message), ["tracking", "tracking", "uncertain"]);
  assert.deepEqual(states.slice(0, 3).map((status) => status.level), [0, 0, 1]);
  const values = Object.fromEntries(states[2].values.map(({ key, value }) => [key, value]));
  assert.equal(values.held, "1");
  assert.equal(values.doubts, "jump, residual");
  assert.equal(values.ct_from_depth.split(" ").length, 12);

  const clock = byTopic.get("/camera/clock")[1];
  assert.deepEqual([clock.time_ref.sec, clock.time_ref.nsec ?? clock.time_ref.nanosec], [7, 33333123]);

  for await (const attachment of reader.readAttachments()) {
    assert.equal(attachment.name, "calibration.json");
    assert.equal(JSON.parse(new TextDecoder().decode(attachment.data)).color.width, 40);
  }
  for await (const metadata of reader.readMetadata()) {
    assert.equal(metadata.metadata.get("case"), "sample");
  }
  return reader;
}

/** Without an end, as after kill -9: the streaming reader gives every whole chunk. */
function checkInterrupted(bytes) {
  const reader = new McapStreamReader({ validateCrcs: true, decompressHandlers });
  reader.append(bytes.subarray(0, bytes.length - 400));
  let messages = 0;
  for (let record = reader.nextRecord(); record; record = reader.nextRecord()) {
    if (record.type === "Message") ++messages;
  }
  assert.ok(messages >= 12 * 4, `${messages} messages`);
}

/** The same messages as another program writes them: channels inside the chunks, not packed. */
async function rewrite(bytes, reader) {
  const parts = [];
  let position = 0n;
  const writer = new McapWriter({
    chunkSize: 4096,
    writable: {
      position: () => position,
      write: async (part) => {
        parts.push(Buffer.from(part));
        position += BigInt(part.length);
      },
    },
  });
  await writer.start({ profile: "ros2", library: "" });
  for await (const attachment of reader.readAttachments()) await writer.addAttachment(attachment);
  const ids = new Map();
  for (const channel of reader.channelsById.values()) {
    const schemaId = await writer.registerSchema(reader.schemasById.get(channel.schemaId));
    ids.set(channel.id, await writer.registerChannel({ ...channel, schemaId }));
  }
  for await (const message of reader.readMessages()) {
    await writer.addMessage({ ...message, channelId: ids.get(message.channelId) });
  }
  await writer.end();
  return Buffer.concat(parts);
}

try {
  const ours = join(folder, "ours.mcap");
  execFileSync(sample, ["write", ours]);
  const bytes = readFileSync(ours);
  const reader = await checkOurs(bytes);
  checkInterrupted(bytes);
  const theirs = join(folder, "theirs.mcap");
  const rewritten = await rewrite(bytes, reader);
  writeFileSync(theirs, rewritten);
  execFileSync(sample, ["read", theirs]);
  // And without its end: no summary, the channels stand in the chunks alone.
  writeFileSync(theirs, rewritten.subarray(0, rewritten.length - 30));
  execFileSync(sample, ["read", theirs]);
  console.log("@mcap/core reads what Morgagni writes, and the other way");
} finally {
  rmSync(folder, { recursive: true });
}
