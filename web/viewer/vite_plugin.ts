// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
import { createHash } from 'node:crypto';
import { readFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { build, type Plugin, type ResolvedConfig, type Rollup } from 'vite';

const folder = fileURLToPath(new URL('.', import.meta.url));

/** Everything in one file; only the one script may run, and nothing comes from outside. */
function onePage(): Plugin {
  return {
    name: 'morgagni-one-page',
    enforce: 'post',
    generateBundle(_options, bundle) {
      const parts = Object.values(bundle);
      const isScript = (part: Rollup.OutputAsset | Rollup.OutputChunk): part is Rollup.OutputChunk =>
        part.type === 'chunk';
      const script = parts.filter(isScript).map((chunk) => chunk.code).join('\n')
        .replaceAll('</script', '<\\/script').trim();
      const style = parts
        .filter((part): part is Rollup.OutputAsset => part.type === 'asset' && part.fileName.endsWith('.css'))
        .map((asset) => String(asset.source)).join('\n');
      const hash = createHash('sha256').update(script).digest('base64');
      const policy = [
        "default-src 'none'", `script-src 'sha256-${hash}'`, "style-src 'unsafe-inline'",
        'img-src data: blob:', 'connect-src blob:', "base-uri 'none'", "form-action 'none'",
      ].join('; ');
      for (const part of parts) delete bundle[part.fileName];
      const page = readFileSync(`${folder}index.html`, 'utf8')
        .replace('%POLICY%', () => policy).replace('%STYLE%', () => style).replace('%SCRIPT%', () => script);
      this.emitFile({ type: 'asset', fileName: 'viewer.html', source: page });
    },
  };
}

/** Builds the offline viewer beside the page: viewer.html, which `morgagni document` fills. */
export function offlineViewer(): Plugin {
  let config: ResolvedConfig | undefined;
  return {
    name: 'morgagni-offline-viewer',
    apply: 'build',
    configResolved(resolved) {
      config = resolved;
    },
    async closeBundle() {
      if (!config || config.configFile === undefined) return;
      await build({
        configFile: false,
        root: folder,
        logLevel: 'warn',
        publicDir: false,
        plugins: [onePage()],
        build: {
          target: 'es2022',
          outDir: new URL(config.build.outDir, `file://${config.root}/`).pathname,
          emptyOutDir: false,
          modulePreload: false,
          cssCodeSplit: false,
          rollupOptions: { input: `${folder}src/main.ts`, output: { inlineDynamicImports: true } },
        },
      });
    },
  };
}
