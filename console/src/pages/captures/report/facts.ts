import { tookS, type Capture } from '@bendtwin/client';
import { h, type Child } from '../../../ui/dom';
import { facts } from '../../../ui/form';
import { count, counted, duration, millimetres, percent, size, time } from '../../../ui/format';
import { table } from '../../../ui/table';
import { settingsView } from '../../parts/settings_view';
import type { CameraReport, Report } from './report';

/** What is known about a capture as numbers, folded away. `report` is null before it is there. */
export function factsCard(capture: Capture, report: Report | null): HTMLElement {
  const { create_time, size_bytes, digest, ingest } = capture;
  const took = tookS(ingest);
  const own: [string, Child][] = [
    ['Uploaded', time(create_time)],
    ['Size', size(size_bytes)],
    ['Read', took === null ? '–' : ['in ', duration(took), ', ', time(ingest.end_time)]],
    ['BLAKE3', h('code', {}, digest.slice(0, 16), '…')],
  ];
  return h(
    'div',
    {},
    h(
      'details',
      { class: 'card' },
      h('summary', {}, 'Facts'),
      facts([...(report === null ? [] : measured(report)), ...own]),
      report === null ? null : camerasView(report.cameras),
    ),
    settingsView('Settings of the ingest', ingest.settings),
  );
}

/** Measurements of the recording in the report. */
function measured({ fps, frame_count, train_frame_count, kind, scene, observed, cameras }: Report): [string, string][] {
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
  return pairs;
}

/** Findings about each camera; null without any. */
function camerasView(cameras: readonly CameraReport[]): HTMLElement | null {
  if (cameras.length === 0) return null;
  const optional = (value: number | null | undefined, text: (value: number) => string): string =>
    value === null || value === undefined ? '–' : text(value);
  return h(
    'section',
    {},
    h('h3', {}, 'Cameras'),
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
