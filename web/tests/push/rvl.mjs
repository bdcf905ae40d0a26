// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// RVL as its paper describes it (Wilson, Fast Lossless Depth Image Compression, ISS 2017, section 3):
// both ways, written apart from Morgagni's decoder, so that each checks the other.

/** @param {Uint16Array} depth @returns {Uint8Array} */
export function encodeRvl(depth) {
  const nibbles = [];
  const put = (value) => {
    do {
      const rest = Math.floor(value / 8);
      nibbles.push((value % 8) + (rest > 0 ? 8 : 0));
      value = rest;
    } while (value > 0);
  };
  let at = 0;
  let previous = 0;
  while (at < depth.length) {
    const zerosFrom = at;
    while (at < depth.length && depth[at] === 0) ++at;
    put(at - zerosFrom);
    const othersFrom = at;
    while (at < depth.length && depth[at] !== 0) ++at;
    put(at - othersFrom);
    for (let i = othersFrom; i < at; ++i) {
      const difference = depth[i] - previous;
      put(difference < 0 ? -2 * difference - 1 : 2 * difference);
      previous = depth[i];
    }
  }
  while (nibbles.length % 8 !== 0) nibbles.push(0);
  const words = new DataView(new ArrayBuffer(nibbles.length / 2));
  for (let i = 0; i < nibbles.length; i += 8) {
    words.setUint32(i / 2, parseInt(nibbles.slice(i, i + 8).map((n) => n.toString(16)).join(''), 16), true);
  }
  return new Uint8Array(words.buffer);
}

/** @param {Uint8Array} packed @param {number} count @returns {Uint16Array} */
export function decodeRvl(packed, count) {
  const words = new DataView(packed.buffer, packed.byteOffset, packed.byteLength);
  const nibbles = [];
  for (let i = 0; i + 4 <= packed.byteLength; i += 4) {
    for (const digit of words.getUint32(i, true).toString(16).padStart(8, '0')) {
      nibbles.push(parseInt(digit, 16));
    }
  }
  let next = 0;
  const take = () => {
    let value = 0;
    for (let scale = 1; ; scale *= 8) {
      const nibble = nibbles[next++];
      value += (nibble % 8) * scale;
      if (nibble < 8) return value;
    }
  };
  const depth = new Uint16Array(count);
  let previous = 0;
  for (let at = 0; at < count; ) {
    at += take();
    for (let others = take(); others > 0; --others) {
      const folded = take();
      previous += folded % 2 === 1 ? -(folded + 1) / 2 : folded / 2;
      depth[at++] = previous;
    }
  }
  return depth;
}
