// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { defineConfig } from 'vitest/config';
import { offlineViewer } from './viewer/vite_plugin';

// `npm run dev` serves the page alone and passes everything else on to a running server.
const server = 'http://127.0.0.1:8080';

export default defineConfig({
  build: {
    target: 'es2022',
    assetsInlineLimit: 0,
    chunkSizeWarningLimit: 700,
    rollupOptions: { input: ['index.html', 'prepare.html', 'calibrate.html'] },
  },
  plugins: [offlineViewer()],
  server: { host: '127.0.0.1', proxy: { '/api': server, '/whep': server } },
  test: { include: ['tests/unit/**/*.test.ts'] },
});
