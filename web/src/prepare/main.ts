// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import '../style/base.css';
import '../style/controls.css';
import './prepare.css';
import { PreparePage } from './prepare_page';

const page = new PreparePage();
document.getElementById('app')?.append(page.element);
page.start();
// For tests and the curious.
Object.assign(window, { morgagni: page.inspection });
