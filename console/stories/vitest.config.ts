import { defineConfig } from 'vitest/config';

/** Stories in Chromium, each file with a server of its own. */
export default defineConfig({
  resolve: { tsconfigPaths: true },
  test: {
    // Pictures of the documents are made on request: they take minutes, and check only what they make.
    include: process.env['BENDTWIN_PICTURES'] === 'make' ? ['stories/pictures.story.ts'] : ['stories/**/*.story.ts'],
    exclude: process.env['BENDTWIN_PICTURES'] === 'make' ? [] : ['stories/pictures.story.ts'],
    environment: 'node',
    testTimeout: 1_200_000,
    hookTimeout: 1_200_000,
    // Bounds, not expectations: what is waited for comes late where other programs take the processor.
    expect: { poll: { timeout: 60_000 } },
    // Chromium draws in software: more than two at once would be slow, not quicker.
    maxWorkers: 2,
    reporters: ['verbose'],
  },
});
