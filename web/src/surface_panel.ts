// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import type { Status, View } from './api';
import { section } from './controls';
import { h, setText } from './dom';
import { FIRST_VIEWPOINT, STANDARD_VIEWS, type FreeViewpoint } from './free_view';
import { icon } from './icons';
import { colorsText } from './status_text';
import { button, choice, iconButton } from './widgets';

const COLORS = [['live', 'Live'], ['fused', 'Fused']] as const;
const PICTURES = [['camera', 'Camera'], ['free', 'Free view']] as const;

/** The body from a side of one's own choice, with the live picture on its skin. */
export class SurfacePanel {
  readonly element: HTMLElement;

  private readonly picture;
  private readonly source;
  private readonly bare: HTMLButtonElement;
  private readonly hole: HTMLButtonElement;
  private readonly colors = h('p', { class: 'tip', 'data-colors': '' });
  private shown: View | undefined;

  constructor(
    private readonly change: (change: Partial<View>) => void,
    zoom: (factor: number) => void,
  ) {
    this.picture = choice('Picture', PICTURES, (picture) => this.send({ picture }));
    // What was never recorded is marked; to see the inside it can still be cut away.
    this.source = choice('Colours', COLORS, (free_colors) =>
      this.send(free_colors === 'fused' ? { picture: 'free', free_colors, free_bare_skin: true }
        : { picture: 'free', free_colors }));
    this.bare = toggle('Skin without colours',
      () => this.send({ free_bare_skin: !this.shown?.free_bare_skin }));
    this.hole = toggle('Hole in the skin',
      () => this.send({ free_hole: !this.shown?.free_hole }));
    this.element = h('div', { class: 'controls surface' },
      section('Free view', this.picture.element, this.colors,
        h('div', { class: 'triple' }, ...STANDARD_VIEWS.map(([word, free_yaw, free_pitch]) =>
          button(word, undefined, () => this.look({ free_yaw, free_pitch })))),
        h('div', { class: 'triple' }, iconButton('Smaller', 'minus', () => zoom(1 / 1.3)),
          iconButton('Larger', 'plus', () => zoom(1.3)),
          button('Reset', undefined, () => this.look(FIRST_VIEWPOINT)))),
      section('Skin', this.source.element, this.bare, this.hole,
        h('p', { class: 'tip' },
          'One finger turns, two move and zoom. Mouse: drag, drag with shift, wheel.'
          + ' What the camera does not see of the skin is cut away.')));
  }

  showView(view: View): void {
    this.shown = view;
    this.picture.show(view.picture);
    this.source.show(view.free_colors);
    this.bare.setAttribute('aria-pressed', String(view.free_bare_skin));
    this.hole.setAttribute('aria-pressed', String(view.free_hole));
  }

  showStatus(status: Status | undefined): void {
    setText(this.colors, status ? colorsText(status) : '');
  }

  /** Choosing a side is asking for the free view. */
  private look(viewpoint: Partial<FreeViewpoint>): void {
    this.send({ picture: 'free', ...viewpoint });
  }

  /** Shows at once what the server will say a little later. */
  private send(change: Partial<View>): void {
    this.change(change);
    if (this.shown) this.showView({ ...this.shown, ...change });
  }
}

function toggle(word: string, onPress: () => void): HTMLButtonElement {
  const key = button(word, undefined, onPress, 'toggle');
  key.setAttribute('aria-pressed', 'false');
  key.append(icon('accept'));
  return key;
}
