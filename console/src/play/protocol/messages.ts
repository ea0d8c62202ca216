import type { World } from '@bendtwin/client';

/** Factors of a twin's own parameters. */
export type Factors = Partial<Record<'stiffness' | 'damping' | 'bending' | 'friction' | 'mass', number>>;

/** A place for a gripper or collider. */
export interface Target {
  readonly index: number;
  readonly position: readonly number[];
}

/** A point of a goal. */
export interface GoalTarget {
  readonly node: number;
  readonly position: readonly number[];
}

/** Messages of a page: docs/formats/play.md, What the browser sends. */
export type Message =
  | { readonly type: 'move'; readonly input: number; readonly grippers?: Target[]; readonly colliders?: Target[] }
  | {
      readonly type: 'grasp';
      readonly input: number;
      readonly gripper: number;
      readonly node: number;
      readonly radius_m: number;
    }
  | { readonly type: 'release'; readonly input: number; readonly gripper: number }
  | { readonly type: 'world'; readonly input: number; readonly world: World; readonly vary: Factors }
  | { readonly type: 'pause'; readonly paused: boolean }
  | { readonly type: 'step'; readonly frames: number }
  | { readonly type: 'speed'; readonly factor: number }
  | { readonly type: 'record'; readonly on: boolean }
  | { readonly type: 'reset' | 'replay' | 'stop' }
  | { readonly type: 'goal'; readonly targets: readonly GoalTarget[]; readonly tolerance_m: number }
  | { readonly type: 'seen'; readonly frame: number };

/** The first text of the server. */
export interface Ready {
  readonly type: 'ready';
  readonly play: string;
  readonly twin: string;
  readonly fps: number;
  readonly nodes: number;
  readonly grippers: readonly { readonly hand: number | null; readonly pose: readonly number[] }[];
  readonly controls: readonly (readonly number[])[];
  readonly hands: readonly number[];
  readonly mass_kg: number | null;
  readonly most_colliders: number;
  readonly recording: string;
}

/** The way to a goal. */
export interface GoalProgress {
  readonly state: 'planning' | 'moving' | 'reached' | 'not_reached' | 'stopped';
  readonly round: number;
  readonly simulated: number;
  readonly planned_m: number | null;
  readonly distance_m: number;
}

/** Facts, every second and after every change. */
export interface Facts {
  readonly type: 'facts';
  readonly paused: boolean;
  readonly speed: number;
  readonly fps: number;
  readonly frame_ms: number;
  readonly behind: number;
  readonly skipped: number;
  readonly watchers: number;
  readonly recording: number | null;
  readonly recorded: number | null;
  readonly replay: readonly [number, number] | null;
  readonly goal: GoalProgress | null;
  readonly world: World;
  readonly vary: Factors;
}

/** A problem in words, with the reason that programs know it by. */
export interface ProblemText {
  readonly detail: string;
  readonly reason: string;
}

/** Texts of the server. */
export type Text =
  | Ready
  | Facts
  | { readonly type: 'refused'; readonly problem: ProblemText }
  | { readonly type: 'notice'; readonly event: string; readonly text: string }
  | { readonly type: 'ended'; readonly problem: ProblemText | null };
