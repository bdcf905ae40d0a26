// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import '../style/base.css';
import './calibrate.css';
import { CalibratePage } from './calibrate_page';

const root = document.querySelector<HTMLElement>('#app');
if (root) {
  const page = new CalibratePage(root);
  // For the tests.
  (window as unknown as { morgagni: CalibratePage }).morgagni = page;
  page.start();
}
