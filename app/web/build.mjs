// One script and one style sheet; the program embeds them.
import { build } from 'esbuild';
import { readFileSync } from 'node:fs';
import { gzipSync } from 'node:zlib';

await build({
  entryPoints: { report: 'src/main.ts' },
  outdir: 'dist',
  bundle: true,
  minify: true,
  format: 'iife',
  target: ['es2022'],
  charset: 'ascii',
  legalComments: 'eof',
});

for (const name of ['report.js', 'report.css']) {
  const file = readFileSync(`dist/${name}`);
  // Inside <script> these would end the element early.
  if (/<\/(script|style)/i.test(file.toString())) throw new Error(`${name} holds a closing tag`);
  console.log(`${name}: ${(file.length / 1024).toFixed(0)} KiB, ${(gzipSync(file).length / 1024).toFixed(0)} KiB gzipped`);
}
