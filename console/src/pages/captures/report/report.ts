/** A capture's report, as docs/use/captures.md has it; what is not needed here is left out. */
export interface Report {
  readonly kind: string;
  readonly fps: number;
  readonly frame_count: number;
  readonly train_frame_count: number;
  readonly verdict: string;
  readonly first_step: string | null;
  readonly findings: readonly Finding[];
  readonly scene?: {
    readonly object_size_m: number | null;
    readonly manipulator_size_m: number | null;
    readonly travel_m: number | null;
    readonly manipulator_travel_m: number | null;
    readonly fastest_m_s: number | null;
    readonly lowest_m: number | null;
    /** Smallest distance between hand and object in each frame. */
    readonly gap_m?: readonly (number | null)[];
  } | null;
  readonly cameras: readonly CameraReport[];
  /** What was taken as what, and what was left out. */
  readonly sources?: {
    readonly taken: readonly { readonly part: string; readonly camera: string | null; readonly from: string; readonly form: string }[];
    readonly left_out: readonly { readonly from: string; readonly because: string }[];
  } | null;
  /** The calibration in use, if one was measured or supplied. */
  readonly calibration?: Calibration | null;
  readonly observed?: {
    readonly point_count: number;
    readonly control_count: number;
    /** In each frame: points that are seen, and those whose motion counts. */
    readonly visible?: readonly number[];
    readonly motion_valid?: readonly number[];
    readonly completed_count: number;
    readonly interior_count: number;
  } | null;
}

export interface Calibration {
  readonly source?: string | null;
  readonly cameras: readonly { readonly name: string; readonly reprojection_px?: number | null }[];
}

export interface Finding {
  readonly severity: 'error' | 'warning' | 'info';
  readonly code: string;
  readonly message: string;
  readonly advice: string;
  readonly cameras?: readonly number[];
  readonly frames?: readonly number[];
  readonly consequences?: readonly string[];
}

/** True if a finding has a code, or explains one that it stands for. */
export function concerns({ code: own, consequences = [] }: Finding, code: string): boolean {
  return own === code || consequences.includes(code);
}

export interface CameraReport {
  readonly name: string;
  readonly width: number;
  readonly height: number;
  readonly missing_frames: readonly number[];
  readonly repeated_frames: readonly number[];
  readonly late_frames: readonly number[];
  readonly empty_masks?: readonly number[];
  readonly mask_jumps?: readonly number[];
  readonly damaged_files: number;
  /** In each frame: pixels of the object, and the share of them that has depth. */
  readonly object_px?: readonly (number | null)[];
  readonly coverage?: readonly (number | null)[];
  readonly median_coverage: number | null;
  readonly skew_ms: number | null;
  readonly tracks?: {
    readonly count: number;
    readonly inside: number | null;
    /** In each frame: tracks that are visible, on a mask, with depth. */
    readonly liftable?: readonly number[];
  } | null;
  readonly agreement?: { readonly disagreement_mm: number | null } | null;
}

/** A picture of the report's page. */
export interface Picture {
  /** A `data:` address of an image. */
  readonly source: string;
  readonly title: string;
  readonly caption: string;
}

const FIGURE = new RegExp(
  '<figure><img alt="([^"]*)" src="(data:image/(?:png|jpeg);base64,[A-Za-z0-9+/=]+)">' +
    '<figcaption>([^<]*)</figcaption>',
  'g',
);
const ENTITIES: Record<string, string> = { amp: '&', lt: '<', gt: '>', quot: '"', '#39': "'" };

/**
 * The pictures of a report's page, which the server writes. They are taken out of its text: the
 * policy of the console lets no text become markup, and the page shows what strangers recorded.
 */
export function picturesOf(page: string): Picture[] {
  const text = (escaped: string): string =>
    escaped.replace(/&(#?\w+);/g, (whole, name: string) => ENTITIES[name] ?? whole);
  return [...page.matchAll(FIGURE)].map(([, title = '', source = '', caption = '']) => ({
    source,
    title: text(title),
    caption: text(caption),
  }));
}
