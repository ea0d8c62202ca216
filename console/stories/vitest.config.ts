import { defineConfig } from 'vitest/config';
import { BaseSequencer, type TestSpecification } from 'vitest/node';

/** Beginnings of the names of the files that take longest, these first: what is begun last should be short. */
const LONG = ['masks', 'fit', 'play.', 'look', 'every_page', 'pages', 'playback', 'embed', 'sign_in', 'upload', 'share'];

/** Begins with the files that take longest, so that both workers end at about the same time. */
class LongestFirst extends BaseSequencer {
  override async sort(files: TestSpecification[]): Promise<TestSpecification[]> {
    const rank = ({ moduleId }: TestSpecification): number => {
      const name = moduleId.slice(moduleId.lastIndexOf('/') + 1);
      const place = LONG.findIndex((part) => name.startsWith(part));
      return place < 0 ? LONG.length : place;
    };
    return [...files].sort((one, other) => rank(one) - rank(other));
  }
}

/** Stories in Chromium, each file with its own server. */
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
    // Chromium draws in software: more than two together would be slower.
    maxWorkers: 2,
    sequence: { sequencer: LongestFirst },
    reporters: ['verbose'],
  },
});
