// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import './style/base.css';
import './style/picture.css';
import './style/figures.css';
import './style/controls.css';
import './style/tabs.css';
import './style/landmarks.css';
import './style/screens.css';
import { App } from './app';

const app = new App();
document.getElementById('app')?.append(app.element);
app.start();
// For tests and the curious: what the page shows, and the pictures with their words.
Object.assign(window, { morgagni: app.inspection });
