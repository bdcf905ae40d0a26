// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { api, isWaiting, listenToStatus, type CaseInfo, type Status, type View, type Waiting } from './api';
import { Controls } from './controls';
import { CtChooser } from './ct_chooser';
import { DocumentsPanel } from './documents_panel';
import { h, setText } from './dom';
import { FindingsPanel } from './findings_panel';
import { FreeGestures } from './free_gestures';
import { zoomed, type FreeViewpoint } from './free_view';
import { grabFrame, type GrabbedFrame } from './frame_grabber';
import type { Point } from './geometry';
import { LandmarkPanel } from './landmark_panel';
import { LiveVideo } from './live_video';
import { ModesPanel } from './modes_panel';
import { PlacementPanel } from './placement_panel';
import { RecordingPanel } from './recording_panel';
import { SelfCalibrationPanel } from './self_calibration_panel';
import { Stage } from './stage';
import { StatusPanel } from './status_panel';
import { adviceOf, bannerOf, snapshotName, touchLines, waitingBanner } from './status_text';
import { SurfacePanel } from './surface_panel';
import { Tabs } from './tabs';
import { TakeawayPanel } from './takeaway_panel';
import { ViewSender } from './view_sender';
import { TexturePanel } from './texture_panel';
import { Toast } from './widgets';

type Mode = 'live' | 'placement' | 'landmarks';

const REFRESH_MS = 200;
// The status comes several times a second; a server that says nothing for so long is not there.
const SILENCE_MS = 4000;

/** The whole page: puts the parts together and passes the status on to them. */
export class App {
  readonly element: HTMLElement;

  private mode: Mode = 'live';
  private status: Status | undefined;
  private heard_ms = 0;
  private waiting: Waiting | undefined;
  private waited_ms = 0;
  /** The server's status shows the landmarks that were begun on this page. */
  private landmarksSeen = false;
  private view: View | undefined;
  private info: CaseInfo | undefined;
  private readonly toast = new Toast();
  private readonly stage = new Stage(() => this.view,
    (hole_x, hole_y) => this.changeView({ hole_x, hole_y }),
    (point) => void this.touch(point));
  private readonly live = new LiveVideo(this.stage.video);
  private readonly figures = new StatusPanel();
  private readonly caseName = h('span', { class: 'case-name' });
  private readonly cts = new CtChooser(this.toast.sayError);
  private readonly sender = new ViewSender((change) => api.setView(change), this.toast.sayError);
  private readonly placement = new PlacementPanel(() => this.closePlacement(), this.toast);
  private readonly landmarks = new LandmarkPanel(this.stage, this.toast, () => this.setMode('live'));
  private readonly modes = new ModesPanel((change) => this.changeView(change));
  private readonly texture = new TexturePanel(this.toast);
  private readonly surface = new SurfacePanel((change) => this.changeView(change),
    (factor) => this.zoomFreeView(factor));
  private readonly controls = new Controls({
    startAutomatically: () => void api.startAutomatically().catch(this.toast.sayError),
    startByPlacement: () => {
      this.setMode('placement');
      this.changeView({ picture: 'camera' });
      this.placement.begin();
    },
    startByLandmarks: () => void this.beginLandmarks(),
    changeView: (change) => this.changeView(change),
    freeze: (frozen) => void api.freeze(frozen).catch(this.toast.sayError),
    snapshot: () => void this.takeSnapshot(),
  });

  private readonly tabs = new Tabs('look');
  private readonly findings = new FindingsPanel(this.stage, this.live, this.toast);
  private readonly takeaway = new TakeawayPanel(this.toast);
  private readonly sensor = new SelfCalibrationPanel(this.toast, (on) => this.tabs.mark('sensor', on));

  readonly inspection: {
    live: LiveVideo;
    readonly status: Status | undefined;
    grabFrame: () => Promise<GrabbedFrame>;
  };

  constructor() {
    this.element = h('main', { class: 'app live' },
      h('header', { class: 'top' },
        h('h1', {}, 'Morgagni'), this.caseName, this.cts.element, this.figures.state,
        h('span', { class: 'notice' }, 'Not a medical device')),
      this.landmarks.skin.element,
      this.stage.element,
      this.figures.element,
      this.landmarks.bar,
      h('aside', { class: 'rail' }, this.tabs.keys, this.tabs.panels, this.controls.keys,
        this.placement.element),
      this.toast.element);
    this.tabs.add('look', this.controls.element);
    this.tabs.add('look', this.modes.element);
    this.tabs.add('surface', this.surface.element);
    this.tabs.add('surface', this.texture.element);
    this.tabs.add('findings', this.findings.element);
    this.tabs.add('take-away', this.takeaway.element);
    this.tabs.add('take-away', new RecordingPanel(this.toast).element);
    this.tabs.add('take-away', new DocumentsPanel(this.toast).element);
    this.tabs.add('sensor', this.sensor.element);
    new FreeGestures(this.stage.element, {
      viewpoint: () => (this.mode === 'live' && this.view?.picture === 'free' ? this.view : undefined),
      radiusMm: () => this.info?.skin_radius_mm ?? 1,
      shown: () => this.stage.shownSize(),
      change: (viewpoint) => {
        this.stage.hideReadout();
        this.changeView(pick(viewpoint));
      },
    });
    const self = this;
    this.inspection = {
      live: this.live,
      get status() {
        return self.status;
      },
      grabFrame: () => grabFrame(this.live),
    };
    window.addEventListener('resize', () => this.landmarks.paint());
  }

  start(): void {
    void this.live.connect();
    void this.loadCase();
    void this.cts.load();
    listenToStatus((status) => (status && isWaiting(status) ? this.showWaiting(status) : this.showStatus(status)));
    setInterval(() => this.refresh(), REFRESH_MS);
    this.refresh();
  }

  private async loadCase(): Promise<void> {
    try {
      this.info = await api.getCase();
    } catch {
      setTimeout(() => void this.loadCase(), 2000);
      return;
    }
    setText(this.caseName, this.info.name);
    document.title = `${this.info.name} – Morgagni`;
    this.controls.showCase(this.info);
    this.modes.showCase(this.info);
    this.placement.showCase(this.info);
  }

  /** There is no camera yet: nothing but that can be shown. */
  private showWaiting(waiting: Waiting): void {
    if (this.status) window.location.reload();
    this.waiting = waiting;
    this.waited_ms = performance.now();
    setText(this.caseName, waiting.case);
    document.title = `${waiting.case} – Morgagni`;
    this.refresh();
  }

  private showStatus(status: Status | undefined): void {
    const before = this.status;
    this.status = status;
    if (!status) return;
    // A session has begun where this page waited for it.
    if (this.waiting) window.location.reload();
    this.heard_ms = performance.now();
    // The server's view is shown once it knows all that was done here.
    if (!this.sender.isBusy) {
      this.view = status.view;
      this.controls.showView(status.view);
      this.modes.showView(status.view);
      this.surface.showView(status.view);
    }
    this.controls.showStatus(status);
    this.surface.showStatus(status);
    const found = status.state === 'tracking' && before?.state !== 'tracking';
    if (this.mode === 'placement' && found) {
      this.setMode('live');
      this.toast.say('The body is found: tracking.', 'good');
    }
    // Another tablet may have ended what was begun here.
    if (this.landmarks.isBegun && status.starting === 'landmarks') this.landmarksSeen = true;
    if (this.landmarksSeen && status.starting !== 'landmarks') this.setMode('live');
    this.refresh();
  }

  private refresh(): void {
    if (performance.now() - this.heard_ms > SILENCE_MS) this.status = undefined;
    const waiting = performance.now() - this.waited_ms < SILENCE_MS ? this.waiting : undefined;
    this.element.classList.toggle('no-camera', waiting !== undefined);
    this.figures.show(this.status, this.live, waiting !== undefined);
    this.sensor.showTracking(this.status?.state);
    if (this.status?.state === 'lost' || this.status?.state === 'waiting') this.stage.hideReadout();
    this.stage.showUncertain(this.mode === 'live' && this.status?.state === 'uncertain');
    if (this.mode !== 'landmarks' && !this.stage.onTap) {
      this.stage.showHint(this.mode === 'placement'
        ? 'Move the camera until the body and the outline match' : adviceOf(this.status));
    }
    this.stage.showBanner(waiting ? waitingBanner(waiting)
      : bannerOf(this.live.state(), this.live.ageMs(), this.live.problem, this.status,
        this.mode === 'landmarks'));
  }

  private changeView(change: Partial<View>): void {
    if (this.view) {
      const structures = { ...this.view.structures, ...change.structures };
      const structure_opacity = { ...this.view.structure_opacity, ...change.structure_opacity };
      this.view = { ...this.view, ...change, structures, structure_opacity };
    }
    this.sender.change(change);
  }

  private zoomFreeView(factor: number): void {
    if (!this.view || !this.info) return;
    const middle = { x: 0, y: 0 };
    this.changeView({ picture: 'free',
      ...pick(zoomed(this.view, factor, middle, this.info.skin_radius_mm, this.stage.shownSize())) });
  }

  private async beginLandmarks(): Promise<void> {
    try {
      this.setMode('landmarks');
      this.changeView({ picture: 'camera' });
      await this.landmarks.begin();
    } catch (error) {
      this.setMode('live');
      this.toast.sayError(error);
    }
  }

  private setMode(mode: Mode): void {
    if (this.mode === 'landmarks' && mode !== 'landmarks') this.landmarks.close();
    if (mode !== 'live') this.findings.leave();
    this.mode = mode;
    this.landmarksSeen = false;
    this.element.className = `app ${mode}`;
    this.stage.hideReadout();
    this.stage.showHint('');
    this.refresh();
  }

  /** Takes the outline away again: the body is searched for as before. */
  private closePlacement(): void {
    if (this.status?.state === 'waiting') {
      void api.startAutomatically().catch(this.toast.sayError);
    }
    this.setMode('live');
  }

  private async touch(point: Point): Promise<void> {
    try {
      this.stage.showReadout(point, touchLines(await api.touch(point)));
    } catch (error) {
      this.stage.hideReadout();
      this.toast.sayError(error);
    }
  }

  private async takeSnapshot(): Promise<void> {
    const response = await fetch('/api/snapshot.png').catch(() => undefined);
    if (!response?.ok) {
      this.toast.say('There is no snapshot: the server has no picture.');
      return;
    }
    const name = snapshotName(this.info?.name ?? '', new Date());
    const url = URL.createObjectURL(await response.blob());
    h('a', { href: url, download: name }).click();
    setTimeout(() => URL.revokeObjectURL(url), 10000);
    this.toast.say(`Saved as ${name}`, 'good');
  }
}

/** The virtual camera alone, of a view that has more. */
function pick({ free_yaw, free_pitch, free_zoom, free_target_mm }: FreeViewpoint): FreeViewpoint {
  return { free_yaw, free_pitch, free_zoom, free_target_mm };
}
