// Builds the part of plotly.js that a page needs. `npm ci && node build.mjs` writes plotly-kinetostat.min.js.
import { createRequire } from 'node:module';
import esbuild from 'esbuild';

const require = createRequire(import.meta.url);
const { glsl } = require('esbuild-plugin-glsl');
const { environmentPlugin } = require('esbuild-plugin-environment');
const inlineCss = require('esbuild-plugin-inline-css');

await esbuild.build({
    entryPoints: ['entry.js'],
    outfile: 'plotly-kinetostat.min.js',
    bundle: true,
    minify: true,
    format: 'iife',
    globalName: 'Plotly',
    target: 'es2016',
    plugins: [inlineCss(), glsl({ minify: true }), environmentPlugin({ NODE_DEBUG: false })],
    alias: { regl: '@plotly/regl', stream: 'stream-browserify' },
    define: { global: 'window', 'define.amd': 'false' },
});
