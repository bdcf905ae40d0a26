// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { describe, expect, it } from 'vitest';
import type { TextureInfo } from '../../src/api';
import { textureAdvice, textureSaved } from '../../src/texture_text';

const info: TextureInfo = {
  ready: true, recording: true, coverage: 0.4, frames: 12, last: 'fused', version: 3,
  saving: false, saved: false, problem: null,
};

describe('textureAdvice', () => {
  it('says what to do for each thing that may become of a picture', () => {
    const outcomes = ['fused', 'nothing new', 'uncertain', 'moving', 'no skin', 'misfit', 'full'];
    const sentences = outcomes.map((last) => textureAdvice({ ...info, last }));
    expect(new Set(sentences).size).toBe(outcomes.length);
    expect(textureAdvice({ ...info, last: 'moving' })).toContain('more slowly');
  });

  it('puts a problem first', () => {
    expect(textureAdvice({ ...info, problem: 'the disk is full' })).toBe('the disk is full');
  });

  it('tells a paused recording from one that has not begun', () => {
    expect(textureAdvice({ ...info, recording: false })).toContain('12 pictures');
    expect(textureAdvice({ ...info, recording: false, frames: 0 })).toContain('Record, and move');
    expect(textureAdvice(undefined)).toContain('does not answer');
  });
});

describe('textureSaved', () => {
  it('says whether the case has it', () => {
    expect(textureSaved(info)).toBe('Not saved yet.');
    expect(textureSaved({ ...info, saved: true })).toBe('Saved in the case.');
    expect(textureSaved({ ...info, frames: 0 })).toBe('');
  });
});
