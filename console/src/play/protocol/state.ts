/** A gripper in a state: a hand of the twin's capture, or a pointer. */
export interface GripperState {
  /** x, y, z [m]. */
  readonly position: readonly [number, number, number];
  /** Quaternion x, y, z, w. */
  readonly orientation: readonly [number, number, number, number];
  /** Force on the object [N], relative where the mass is not known. */
  readonly force: readonly [number, number, number];
  readonly holds: boolean;
}

/** A state of a play: docs/formats/play.md, What the server sends. */
export interface PlayState {
  readonly isPaused: boolean;
  readonly isRecording: boolean;
  readonly isReplaying: boolean;
  readonly isPursuing: boolean;
  readonly number: number;
  /** The last input that it has. */
  readonly input: number;
  /** Largest strain of the material. */
  readonly strain: number;
  readonly grippers: readonly GripperState[];
  /** Poses of the colliders, position and quaternion, shape [C, 7]. */
  readonly colliders: Float32Array;
  /** Nodes [m], shape [N, 3]. */
  readonly positions: Float32Array;
}

const KIND = 1;
const HEAD = 36;
const GRIPPER = 44;
const COLLIDER = 28;

/** Reads a state; throws if the message is invalid. */
export function decodeState(message: ArrayBuffer): PlayState {
  if (message.byteLength < HEAD) throw new Error('a state is cut off');
  const view = new DataView(message);
  const float = (at: number): number => view.getFloat32(at, true);
  const [kind, flags] = [view.getUint8(0), view.getUint8(1)];
  const [grippers, colliders] = [view.getUint8(2), view.getUint8(3)];
  if (kind !== KIND) throw new Error(`messages of kind ${kind} are unknown`);
  const nodes = view.getUint32(12, true);
  const first = HEAD + GRIPPER * grippers + COLLIDER * colliders;
  if (message.byteLength !== first + 6 * nodes) throw new Error('a state has a wrong length');
  const list = (at: number, length: number): number[] => Array.from({ length }, (_, i) => float(at + 4 * i));
  return {
    isPaused: (flags & 1) !== 0,
    isRecording: (flags & 2) !== 0,
    isReplaying: (flags & 4) !== 0,
    isPursuing: (flags & 8) !== 0,
    number: view.getUint32(4, true),
    input: view.getUint32(8, true),
    strain: float(32),
    grippers: Array.from({ length: grippers }, (_, g) => {
      const at = HEAD + GRIPPER * g;
      return {
        position: list(at, 3) as unknown as GripperState['position'],
        orientation: list(at + 12, 4) as unknown as GripperState['orientation'],
        force: list(at + 28, 3) as unknown as GripperState['force'],
        holds: float(at + 40) !== 0,
      };
    }),
    colliders: new Float32Array(list(HEAD + GRIPPER * grippers, 7 * colliders)),
    positions: nodesOf(view, first, nodes),
  };
}

function nodesOf(view: DataView, first: number, nodes: number): Float32Array {
  const origin = [view.getFloat32(16, true), view.getFloat32(20, true), view.getFloat32(24, true)] as const;
  const scale = view.getFloat32(28, true);
  const positions = new Float32Array(3 * nodes);
  for (let i = 0; i < positions.length; i += 1) {
    positions[i] = origin[i % 3]! + scale * view.getInt16(first + 2 * i, true);
  }
  return positions;
}
