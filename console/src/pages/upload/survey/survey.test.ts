import { describe, expect, test } from 'vitest';

import { entryOf, type Entry } from './entries';
import { surveyOf } from './survey';

function entries(paths: readonly string[], documents: Record<string, unknown> = {}): Entry[] {
  const texts = Object.entries(documents).map(([path, value]) => entryOf(path, new Blob([JSON.stringify(value)])));
  return [...paths.map((path) => entryOf(path, new Blob(['x']))), ...texts];
}

const RAW = ['0', '1'].flatMap((camera) => [
  `case/color/${camera}/0.png`,
  `case/color/${camera}/1.png`,
  `case/depth/${camera}/0.npy`,
]);
const METADATA = { 'case/metadata.json': { intrinsics: [1, 2], WH: [4, 3] } };
const MASKS = ['case/mask/mask_info_0.json', 'case/mask/0/1/0.png'];

describe('what is found in a raw case', () => {
  test('is complete with images, depth, masks and calibration', async () => {
    const survey = await surveyOf(entries([...RAW, ...MASKS, 'case/calibrate.pkl', 'case/cotracker/0.npz'], METADATA), true);
    expect(survey).toMatchObject({ format: 'Raw recording', facts: ['2 cameras', '2 frames', 'PNG images'], notes: [], isComplete: true });
    expect(survey.parts).toEqual([['depth', true], ['masks', true], ['calibration', true], ['tracks', true]]);
  });

  test('without masks and calibration says what can be done', async () => {
    const survey = await surveyOf(entries([...RAW, 'case/mask/mask_info_0.json'], METADATA), true);
    expect(survey.isComplete).toBe(false);
    expect(survey.notes.map(({ section }) => section)).toEqual(['masks', 'calibration']);
    expect(survey.notes[0]?.text).toMatch(/^No masks: you can mark the object/);
  });

  test('without depth of a camera is not complete', async () => {
    const files = [...RAW.filter((path) => !path.startsWith('case/depth/1')), ...MASKS, 'case/calibrate.pkl'];
    const survey = await surveyOf(entries(files, METADATA), true);
    expect(survey.notes.map(({ section }) => section)).toEqual(['depth']);
  });

  test('of a part of an archive is not said to be missing', async () => {
    const survey = await surveyOf(entries(RAW, METADATA), false);
    expect(survey.notes).toEqual([{ text: 'Only the beginning of this archive could be looked into.' }]);
    expect(survey.parts).toEqual([['depth', true]]);
  });
});

describe('what is found in a bundle', () => {
  const camera = { pose: {}, color: 'left/{frame:06}.jpg', depth: { files: 'depth/{frame:06}.png' }, masks: { object: ['mask/{frame}.png'] } };
  const files = ['toy/left/000000.jpg', 'toy/depth/000000.png', 'toy/mask/0.png'];
  const document = (change: object): Record<string, unknown> => ({
    'toy/capture.json': { raw: { frame_count: 100, cameras: [{ ...camera, ...change }] } },
  });

  test('is what its document names and its files have', async () => {
    expect(await surveyOf(entries(files, document({})), true)).toMatchObject({
      facts: ['1 camera', '100 frames', 'JPEG images'],
      notes: [],
      isComplete: true,
    });
    const noMasks = await surveyOf(entries(files.slice(0, 2), document({})), true);
    expect(noMasks.notes.map(({ section }) => section)).toEqual(['masks']);
    const noPose = await surveyOf(entries(files, document({ pose: undefined })), true);
    expect(noPose.notes.map(({ section }) => section)).toEqual(['calibration']);
    expect((await surveyOf(entries([], document({})), true)).notes[0]?.text).toMatch(/^The colour images/);
  });

  test('of tracked points needs them', async () => {
    const sequences = { 'capture.json': { sequences: [{}, {}] } };
    expect(await surveyOf(entries(['object_points.npy'], sequences), true)).toMatchObject({ facts: ['2 sequences'], isComplete: true });
    expect((await surveyOf(entries([], sequences), true)).isComplete).toBe(false);
  });

  test('that is damaged is said', async () => {
    const survey = await surveyOf([entryOf('capture.json', new Blob(['{']))], true);
    expect(survey).toMatchObject({ isComplete: false, notes: [{ text: 'capture.json cannot be read: it is no JSON.' }] });
  });
});

test('other forms are recognised by their documents', async () => {
  const frames = ['a', 'b'].flatMap((folder) =>
    [0, 1, 2].map((frame) => ({ file_path: `${folder}/${frame}.png`, depth_file_path: 'd.png', mask_path: 'm.png' })),
  );
  const nerf = await surveyOf(entries([], { 'transforms.json': { frames } }), true);
  expect(nerf).toMatchObject({ facts: ['2 cameras', '3 frames', 'PNG images'], isComplete: true });
  expect((await surveyOf(entries(['x/final_data.pkl']), true)).notes[0]?.text).toMatch(/^No metadata\.json/);
  expect((await surveyOf(entries(['x/final_data.pkl', 'x/metadata.json']), true)).isComplete).toBe(true);
  expect(await surveyOf(entries(['x/final_data.pkl', 'y/final_data.pkl']), true)).toMatchObject({ format: 'Several captures' });
  expect(await surveyOf(entries(['a/run.mcap', 'a/metadata.yaml']), true)).toMatchObject({ format: 'MCAP recording' });
  const unknown = await surveyOf(entries(['photo.png', '__MACOSX/capture.json', '.git/capture.json']), true);
  expect(unknown).toMatchObject({ format: 'Not recognised', isComplete: false });
});

test('several recordings say which lacks what', async () => {
  const files = ['a/final_data.pkl', 'a/metadata.json', 'b/final_data.pkl'];
  const survey = await surveyOf(entries(files, { 'recordings.json': {} }), true);
  expect(survey).toMatchObject({ facts: ['2 recordings'], isComplete: false });
  expect(survey.notes.map(({ text }) => text.slice(0, 6))).toEqual(['b/: No']);
});
