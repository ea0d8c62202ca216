import { h } from '../../ui/dom';
import { facts } from '../../ui/form';
import { count, counted, duration, millimetres, percent } from '../../ui/format';
import { table } from '../../ui/table';
import type { CameraReport, Report } from './report';

/** Measurements of the recording in the report, as facts. */
export function factsView({
  fps,
  frame_count,
  train_frame_count,
  kind,
  scene,
  observed,
  cameras,
}: Report): HTMLElement {
  const pairs: [string, string][] = [
    ['Length', fps > 0 ? `${counted(frame_count, 'frame')}, ${duration(frame_count / fps)} at ${fps} per second` : 'unknown'],
    ['For fitting', train_frame_count > 0 ? `frames 0 to ${train_frame_count - 1}` : 'none'],
    ['Kind', kind === 'recording' ? `colour and depth of ${cameras.length} cameras` : 'tracked points'],
  ];
  if (observed) {
    pairs.push(['Tracked points', count(observed.point_count)], ['Control points', count(observed.control_count)]);
    pairs.push(['Completed, interior points', `${count(observed.completed_count)}, ${count(observed.interior_count)}`]);
  }
  if (scene) {
    pairs.push(
      ['Size of the object', millimetres(scene.object_size_m)],
      ['Object moves by', millimetres(scene.travel_m)],
    );
    pairs.push(
      ['Hand moves by', millimetres(scene.manipulator_travel_m)],
      ['Lowest above ground', millimetres(scene.lowest_m)],
    );
    if (scene.fastest_m_s !== null) pairs.push(['Fastest', `${scene.fastest_m_s.toFixed(2)} m/s`]);
  }
  return facts(pairs);
}

/** Findings about each camera. */
export function camerasView(cameras: readonly CameraReport[]): HTMLElement | null {
  if (cameras.length === 0) return null;
  const optional = (value: number | null | undefined, text: (value: number) => string): string =>
    value === null || value === undefined ? '–' : text(value);
  return h(
    'section',
    {},
    h('h2', {}, 'Cameras'),
    table<CameraReport>({
      caption: 'Cameras',
      hidesCaption: true,
      rows: cameras,
      columns: [
        { header: 'Camera', cell: (c) => h('bdi', {}, c.name) },
        { header: 'Pixels', isNumeric: true, cell: (c) => `${c.width} × ${c.height}` },
        { header: 'Missing', isNumeric: true, cell: (c) => c.missing_frames.length },
        { header: 'Repeated', isNumeric: true, cell: (c) => c.repeated_frames.length },
        { header: 'Late', isNumeric: true, cell: (c) => c.late_frames.length },
        { header: 'Damaged', isNumeric: true, cell: (c) => c.damaged_files },
        { header: 'Skew', isNumeric: true, cell: (c) => optional(c.skew_ms, (ms) => `${ms.toFixed(0)} ms`) },
        { header: 'Depth coverage', isNumeric: true, cell: (c) => optional(c.median_coverage, percent) },
        { header: 'Tracks', isNumeric: true, cell: (c) => optional(c.tracks?.count, count) },
        {
          header: 'Disagreement',
          isNumeric: true,
          cell: (c) => optional(c.agreement?.disagreement_mm, (mm) => `${mm.toFixed(1)} mm`),
        },
      ],
    }),
  );
}
