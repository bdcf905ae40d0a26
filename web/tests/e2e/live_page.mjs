// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// Starts a server, opens its page in a real Chromium with a fresh profile, and takes pictures out
// of the video together with what the server said about exactly those pictures.

import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { mkdtemp, rm } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { createInterface } from 'node:readline';
import { chromium } from 'playwright-core';

const BROWSER_FLAGS = [
  '--headless',
  '--no-sandbox',
  '--disable-gpu',
  '--disable-quic',
  '--no-first-run',
  '--disable-background-networking',
  '--disable-component-update',
  '--disable-sync',
];

/**
 * Runs a server command and waits for the address it prints (http://127.0.0.1:PORT).
 * `says` waits for what it prints besides.
 * @returns {Promise<{url: string, says: (pattern: RegExp) => Promise<string>, stop: () => Promise<number|null>,
 *   log: string[], pid: number}>}
 */
export async function startServer(command, { timeout_ms = 60000, env = process.env } = {}) {
  const [program, ...parameters] = command;
  const process_ = spawn(program, parameters, { stdio: ['ignore', 'pipe', 'pipe'], env });
  // A test that fails does not reach its stop().
  process.once('exit', () => process_.kill('SIGKILL'));
  const log = [];
  const ended = new Promise((resolve) => process_.once('exit', resolve));
  const url = await new Promise((resolve, reject) => {
    const timer = setTimeout(() => reject(failure('printed no address')), timeout_ms);
    const failure = (what) => new Error(`${program} ${what}:\n${log.join('\n')}`);
    const read = (line) => {
      log.push(line);
      const found = /http:\/\/(127\.0\.0\.1|localhost):\d+/.exec(line);
      if (!found) return;
      clearTimeout(timer);
      resolve(found[0]);
    };
    createInterface(process_.stdout).on('line', read);
    createInterface(process_.stderr).on('line', read);
    process_.once('error', (error) => reject(failure(`does not start (${error.message})`)));
    process_.once('exit', (code) => {
      clearTimeout(timer);
      reject(failure(`ended with ${code}`));
    });
  }).catch((error) => {
    process_.kill('SIGKILL');
    throw error;
  });
  const says = async (pattern) => {
    const until = Date.now() + timeout_ms;
    while (Date.now() < until) {
      const found = log.map((line) => pattern.exec(line)).find(Boolean);
      if (found) return found[0];
      await new Promise((resolve) => setTimeout(resolve, 50));
    }
    throw new Error(`${program} never said ${pattern}:\n${log.join('\n')}`);
  };
  const stop = async () => {
    process_.kill('SIGTERM');
    const timer = setTimeout(() => process_.kill('SIGKILL'), 10000);
    const code = await ended;
    clearTimeout(timer);
    return code;
  };
  return { url, says, stop, log, pid: process_.pid };
}

/** One page in a browser of its own. */
export class LivePage {
  /** @param {{width?: number, height?: number, touch?: boolean}} [size] */
  static async open(url, { width = 1024, height = 768, touch = true } = {}) {
    const profile = await mkdtemp(join(tmpdir(), 'morgagni-browser-'));
    const context = await chromium.launchPersistentContext(profile, {
      executablePath: process.env.MORGAGNI_CHROMIUM ?? '/usr/bin/chromium',
      headless: true,
      args: BROWSER_FLAGS,
      viewport: { width, height },
      hasTouch: touch,
      acceptDownloads: true,
    });
    const page = context.pages()[0] ?? (await context.newPage());
    const live = new LivePage(context, page, profile);
    page.on('pageerror', (error) => live.errors.push(String(error)));
    page.on('console', (message) => {
      if (message.type() === 'error') live.errors.push(message.text());
    });
    await page.goto(url);
    return live;
  }

  constructor(context, page, profile) {
    this.context = context;
    this.page = page;
    this.profile = profile;
    /** What the page itself complained about. */
    this.errors = [];
  }

  /** Waits until pictures are shown. @returns milliseconds since the page was opened */
  async wait_for_picture(timeout_ms = 20000) {
    await this.page.waitForFunction(
      () => window.morgagni?.live.state() === 'live', undefined, { timeout: timeout_ms });
    return this.page.evaluate(() => performance.now());
  }

  /** Waits for a tracking state ("waiting", "tracking", "uncertain", "lost"). */
  async wait_for_state(state, timeout_ms = 20000) {
    await this.page.waitForFunction(
      (wanted) => window.morgagni?.status?.state === wanted, state, { timeout: timeout_ms });
  }

  status() {
    return this.page.evaluate(() => window.morgagni.status);
  }

  /**
   * The next `count` pictures that the browser can hand over (not each one that is shown).
   * @returns {Promise<{rtp: number, at_ms: number, width: number, height: number, pixels: Buffer,
   *   info: object|null}[]>} pixels: RGBA, row by row
   */
  async grab_frames(count) {
    const frames = [];
    for (let i = 0; i < count; ++i) {
      const frame = await this.page.evaluate(() => window.morgagni.grabFrame());
      frames.push({ ...frame, pixels: Buffer.from(frame.pixels, 'base64') });
    }
    return frames;
  }

  /** Rate and latency of all pictures that the page shows in the given time. */
  measure(duration_ms) {
    return this.page.evaluate(async (wait_ms) => {
      const { live } = window.morgagni;
      const shown = [];
      let listening = true;
      live.onPicture((picture) => {
        if (listening) shown.push(picture);
      });
      const latencies = [];
      const started = performance.now();
      while (performance.now() - started < wait_ms) {
        await new Promise((resolve) => setTimeout(resolve, 250));
        const latency = live.latencyMs();
        if (latency !== undefined) latencies.push(latency);
      }
      listening = false;
      const gaps = shown.slice(1).map((picture, i) => picture.at_ms - shown[i].at_ms);
      gaps.sort((a, b) => a - b);
      latencies.sort((a, b) => a - b);
      const span_ms = shown.length > 1 ? shown.at(-1).at_ms - shown[0].at_ms : Infinity;
      return {
        frames: shown.length,
        frame_rate: ((shown.length - 1) * 1000) / span_ms,
        gap_ms: { median: gaps[gaps.length >> 1], p95: gaps[Math.floor(gaps.length * 0.95)] },
        latency_ms: latencies[latencies.length >> 1] ?? null,
        with_info: shown.filter((picture) => picture.info).length,
      };
    }, duration_ms);
  }

  async screenshot(path) {
    await this.page.screenshot({ path });
  }

  async close() {
    await this.context.close();
    await rm(this.profile, { recursive: true, force: true });
  }
}

/**
 * Runs a page test's steps one after the other and says how it went; the page and the server are
 * closed in any case.
 * @param {{live: LivePage, server: object, shoot: (name: string) => Promise<void>,
 *   is_expected?: (error: string) => boolean}} test  What the page may complain of; else nothing.
 * @param {(() => Promise<void>)[]} steps
 */
export async function runSteps({ live, server, shoot, is_expected = () => false }, steps) {
  try {
    await live.wait_for_picture();
    for (const step of steps) {
      await step().catch((error) => {
        throw new Error(`${step.name}: ${error.message}`);
      });
    }
    assert.deepEqual(live.errors.filter((text) => !is_expected(text)), [], 'the page complains');
    console.log('{"ok": true}');
  } catch (error) {
    await shoot('failure');
    console.error(error.message, '\n', server.log.slice(-10).join('\n'));
    process.exitCode = 1;
  } finally {
    await live.close();
    await server.stop();
  }
}
