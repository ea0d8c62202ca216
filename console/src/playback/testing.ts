import type { CameraHead, SequenceHead } from './file/head';

/** A camera at the origin that looks along z, with images of 100 x 80 pixels. */
export function camera(changes: Partial<CameraHead> = {}): CameraHead {
  return {
    name: 'left',
    size: [100, 80],
    intrinsics: { fx: 100, fy: 90, cx: 50, cy: 40 },
    distortion: { model: 'none', coefficients: [] },
    poses: [0, 48],
    images: { size: [100, 80], every: 1, lengths: [], bytes: [48, 0] },
    ...changes,
  };
}

/** A sequence of two frames with two points and a control point. */
export function sequence(changes: Partial<SequenceHead> = {}): SequenceHead {
  return {
    recording: 0,
    recording_name: 'toy',
    name: '',
    fps: 30,
    frame_count: 2,
    train_frame_count: 1,
    start_frame: 0,
    ground: null,
    observed_points: 2,
    motion: {
      point_count: 2,
      control_count: 1,
      origin: [1, 0, 0],
      scale_m: 0.001,
      points: [0, 24],
      visible: [24, 2],
      controls: [26, 12],
      colors: null,
    },
    cameras: [],
    ...changes,
  };
}

/** The bytes of a playback file. */
export function fileOf(head: unknown, data: Uint8Array): Uint8Array<ArrayBuffer> {
  const json = new TextEncoder().encode(JSON.stringify(head));
  const bytes = new Uint8Array(16 + json.length + data.length);
  bytes.set(new TextEncoder().encode('BENDPLAY'));
  const view = new DataView(bytes.buffer);
  view.setUint32(8, 1, true);
  view.setUint32(12, json.length, true);
  bytes.set(json, 16);
  bytes.set(data, 16 + json.length);
  return bytes;
}

/** Numbers as little-endian int16. */
export function int16(...numbers: number[]): Uint8Array {
  const view = new DataView(new ArrayBuffer(2 * numbers.length));
  numbers.forEach((number, i) => view.setInt16(2 * i, number, true));
  return new Uint8Array(view.buffer);
}
