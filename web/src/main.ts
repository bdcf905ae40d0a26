// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { grabFrame } from './frame_grabber';
import { LiveVideo } from './live_video';

const video = document.createElement('video');
video.muted = true;
video.playsInline = true;
document.body.append(video);
const live = new LiveVideo(video);
void live.connect();
Object.assign(window, { morgagni: { live, grabFrame: () => grabFrame(live) } });
