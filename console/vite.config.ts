import { defineConfig } from 'vitest/config';

/** A server that `npm run dev` hands the API's requests to. */
const server = process.env['BENDTWIN_SERVER'] ?? 'http://127.0.0.1:7070';

export default defineConfig({
  base: './',
  resolve: { tsconfigPaths: true },
  build: {
    target: 'es2023',
    // Everything comes as a separate file: the policy of the page allows nothing inline.
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    chunkSizeWarningLimit: 700,
    // What all pages share comes with the frame, in one file instead of one for each module; what only pages of
    // twins read does not.
    rolldownOptions: { checks: { pluginTimings: false }, output: { codeSplitting: { groups: [{ name: 'shared', test: /console[\\/]src[\\/](api|ui)[\\/]|client[\\/]typescript[\\/]src[\\/](?!twin_file|tensor)/ }] } } },
  },
  server: { fs: { allow: ['..'] }, proxy: { '/v1': { target: server, ws: true }, '/metrics': server, '/healthz': server } },
  test: { include: ['src/**/*.test.ts', '../client/typescript/src/**/*.test.ts'], environment: 'node' },
});
