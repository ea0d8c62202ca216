import { describe, expect, test } from 'vitest';

import { nameOf, packagesOf, type FolderFile, type Package } from './select';

function files(names: readonly string[], documents: Record<string, string> = {}): FolderFile[] {
  return names.map((path) => ({ path, file: new File([documents[path] ?? ''], path.split('/').at(-1) ?? '') }));
}

function sent(packages: readonly Package[]): [string, string[]][] {
  return packages.map((p) => [p.name, p.kind === 'file' ? [p.file.name] : p.files.map(({ path }) => path)]);
}

describe('the files of a folder that are sent', () => {
  test('of a raw PhysTwin case are those that its reader reads', async () => {
    const read = [
      'calibrate.pkl',
      'color/0/0.png',
      'color/1/frame_7.JPG',
      'cotracker/0.npz',
      'depth/0/0.npy',
      'gt_track_3d.pkl',
      'mask/0/1/0.png',
      'mask/mask_info_0.json',
      'metadata.json',
      'shape/matching/final_mesh.glb',
      'split.json',
    ];
    const other = [
      '.DS_Store',
      'color/.cache/0.png',
      'color/0.mp4',
      'pcd/0.npz',
      'shape/object.png',
      '__MACOSX/metadata.json',
    ];
    const [only, ...more] = await packagesOf('toy', files([...other, ...read]));
    expect(more).toEqual([]);
    expect(only).toMatchObject({ kind: 'folder', name: 'toy', left: 3 });
    expect(sent([only as Package])[0]?.[1]).toEqual(read);
  });

  test('of a raw case have masks and calibrations in any form', async () => {
    const read = [
      'calibration.json',
      'color/0/0.jpg',
      'depth/0/0.npy',
      'json_data/mask_0.json',
      'mask/0.npz',
      'mask_data/mask_0.npy',
      'metadata.json',
    ];
    expect(sent(await packagesOf('case', files([...read, 'color/0.mp4', 'notes.docx'])))).toEqual([['case', read]]);
  });

  test('of a recording that was split are one capture', async () => {
    const read = ['bag_0.mcap', 'bag_1.mcap.zstd', 'metadata.yaml'];
    expect(sent(await packagesOf('run', files([...read, 'notes.pdf'])))).toEqual([['run', read]]);
    const names = ['a.mcap', 'b.mcap'];
    expect(sent(await packagesOf('run', files(names))).map(([name]) => name)).toEqual(['a', 'b']);
  });

  test('of a processed case leave out the images', async () => {
    const packages = await packagesOf(
      'case',
      files(['final_data.pkl', 'metadata.json', 'color/0/0.png', 'split.json']),
    );
    expect(sent(packages)).toEqual([['case', ['final_data.pkl', 'metadata.json', 'split.json']]]);
    expect(packages[0]).toMatchObject({ left: 1, note: expect.stringContaining('the points are used') as string });
  });

  test('of several cases, however deep, are one capture each', async () => {
    const deep = 'data/different_types/';
    const names = [
      `${deep}a/final_data.pkl`,
      `${deep}a/metadata.json`,
      `${deep}b/final_data.pkl`,
      'data/notes.txt',
      'data/old.tar.gz',
    ];
    expect(sent(await packagesOf('PhysTwin', files(names)))).toEqual([
      ['a', ['final_data.pkl', 'metadata.json']],
      ['b', ['final_data.pkl']],
      ['old', ['old.tar.gz']],
    ]);
  });

  test('of a raw bundle are those that its document names', async () => {
    const document = JSON.stringify({
      raw: {
        cameras: [
          { color: './l/{frame:06}.png', depth: { files: 'd{frame}/x.npy' }, masks: { object: ['m+(1)/{frame}.png'] } },
        ],
      },
    });
    const names = [
      'capture.json',
      'd12/x.npy',
      'l/000001.png',
      'l/preview.png',
      'm+(1)/3.png',
      'mm(1)/3.png',
      'readme.md',
    ];
    expect(sent(await packagesOf('b', files(names, { 'capture.json': `\ufeff${document}` })))).toEqual([
      ['b', ['capture.json', 'd12/x.npy', 'l/000001.png', 'm+(1)/3.png']],
    ]);
  });

  test('have the calibration and the grippers beside a bundle or nerfstudio, with the arrays that these name', async () => {
    const grippers = JSON.stringify({ grippers: [{ poses: './robot/poses.NPY', widths: 'widths.npy' }] });
    const beside = ['calibration.json', 'grippers.json', 'robot/poses.NPY', 'widths.npy'];
    const nerfstudio = { 'transforms.json': '{"frames": [{"file_path": "a.png"}]}', 'grippers.json': grippers };
    const all = ['a.png', 'b.png', 'notes.json', 'other/x.npy', 'transforms.json', ...beside];
    const read = ['a.png', 'transforms.json', ...beside].sort();
    expect(sent(await packagesOf('n', files(all, nerfstudio)))).toEqual([['n', read]]);
    const bundle = { 'capture.json': '{"raw": {"cameras": [{"color": "{frame}.png"}]}}', 'grippers.json': grippers };
    expect(sent(await packagesOf('b', files(['1.png', 'capture.json', 'notes.json', ...beside], bundle)))).toEqual([
      ['b', ['1.png', 'calibration.json', 'capture.json', 'grippers.json', 'robot/poses.NPY', 'widths.npy']],
    ]);
    const damaged = files(['b.png', 'grippers.json', 'transforms.json'], { ...nerfstudio, 'grippers.json': '{' });
    expect(sent(await packagesOf('n', damaged))).toEqual([['n', ['b.png', 'grippers.json', 'transforms.json']]]);
  });

  test('have the calibration beside MCAP files, of one recording or of several', async () => {
    const split = ['bag_0.mcap', 'bag_1.mcap', 'calibration.json', 'metadata.yaml'];
    expect(sent(await packagesOf('run', files(split)))).toEqual([['run', split]]);
    expect(sent(await packagesOf('day', files(['r/a.mcap', 'r/b.mcap.zst', 'r/calibration.json', 'c.mcap'])))).toEqual([
      ['c', ['c.mcap']],
      ['a', ['calibration.json', 'a.mcap']],
      ['b', ['calibration.json', 'b.mcap.zst']],
    ]);
  });

  test('have the grippers beside MCAP files, with what they are read from', async () => {
    const grippers = { 'grippers.json': '{"grippers": [{"poses": {"lerobot": {"file": "data/0.parquet"}}}]}' };
    const split = ['bag_0.mcap', 'data/0.parquet', 'grippers.json', 'metadata.yaml'];
    const other = ['data/1.parquet', 'notes.txt'];
    expect(sent(await packagesOf('run', files([...split, ...other], grippers)))).toEqual([['run', split]]);
    const alone = ['a.mcap', 'data/0.parquet', 'grippers.json', ...other];
    expect(sent(await packagesOf('day', files(alone, grippers)))).toEqual([
      ['a', ['data/0.parquet', 'grippers.json', 'a.mcap']],
    ]);
    const damaged = files(alone, { 'grippers.json': '{' });
    expect(sent(await packagesOf('day', damaged))).toEqual([['a', ['grippers.json', 'a.mcap']]]);
  });

  test('are all of them where a document is damaged or nothing is recognised', async () => {
    const damaged = await packagesOf('b', files(['capture.json', 'a.png'], { 'capture.json': '{' }));
    expect(sent(damaged)).toEqual([['b', ['a.png', 'capture.json']]]);
    expect(sent(await packagesOf('b', files(['x/a.png', 'b.txt'])))).toEqual([['b', ['b.txt', 'x/a.png']]]);
    expect(await packagesOf('empty', files(['.hidden']))).toEqual([]);
    expect(await packagesOf('letters', files(['a.txt', 'b/c.pdf']))).toEqual([]);
  });

  test('of several recordings of one object stay one capture', async () => {
    const names = [
      'recordings.json',
      'one/final_data.pkl',
      'one/metadata.json',
      'one/color/0/0.png',
      'two/transforms.json',
      'two/a.png',
      'two/b.png',
    ];
    const documents = { 'recordings.json': '{}', 'two/transforms.json': '{"frames": [{"file_path": "./a.png"}]}' };
    expect(sent(await packagesOf('o', files(names, documents)))).toEqual([
      ['o', ['recordings.json', 'one/final_data.pkl', 'one/metadata.json', 'two/a.png', 'two/transforms.json']],
    ]);
  });
});

test('names of captures are those of their files without the format', () => {
  const names = ['toy.v2.tar.gz', 'rope.ZIP', 'a.mcap', 'take.C3D', 'take 2.csv', 'b.trc', '.zip'];
  expect(names.map(nameOf)).toEqual(['toy.v2', 'rope', 'a', 'take', 'take 2', 'b', '.zip']);
});
