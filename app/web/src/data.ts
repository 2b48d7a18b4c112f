// Reads what app/report/pack.cpp wrote. The format is described in app/web/README.md.

export interface ArrayRef {
  at: number;
  n: number;
  type: 'i16' | 'i32';
  scale: number;
  origin: number;
}

/** One gzipped block of quantised, differenced, byte-plane split arrays. */
export class Block {
  constructor(private readonly bytes: Uint8Array) {}

  static async unpack(base64: string): Promise<Block> {
    const text = atob(base64);
    const packed = new Uint8Array(text.length);
    for (let i = 0; i < text.length; ++i) packed[i] = text.charCodeAt(i);
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('gzip'));
    return new Block(new Uint8Array(await new Response(stream).arrayBuffer()));
  }

  read(ref: ArrayRef): Float64Array {
    const { at, n, scale, origin } = ref;
    const b = this.bytes;
    const out = new Float64Array(n);
    const wide = ref.type === 'i32';
    let q = 0;
    for (let i = 0; i < n; ++i) {
      let d = b[at + i] | (b[at + n + i] << 8);
      if (wide) d |= (b[at + 2 * n + i] << 16) | (b[at + 3 * n + i] << 24);
      q = wide ? (q + d) | 0 : ((q + d) << 16) >> 16;
      out[i] = q === (wide ? -2147483648 : -32768) ? NaN : origin + scale * q;
    }
    return out;
  }
}

export interface Channel {
  unit: string;
  description: string;
  data?: ArrayRef;
  components?: ArrayRef[];
}

export interface Statistics {
  mean: number;
  rms: number;
  sd: number;
  min: number;
  max: number;
}

export interface Assumption {
  file: string;
  key: string;
  value: string;
  why: string;
}

export interface Summary {
  simulated_s: number;
  distance_m: number | null;
  mean_speed_mps: number | null;
  energy_per_metre: number | null;
  battery_per_metre: number | null;
  max_sinkage_m: number | null;
  deepest_wheel: string;
  joint_drift_m: number;
  energy_residual_J: number | null;
  energy_residual_ratio: number | null;
  energy_yardstick_J: number | null;
  energy_yardstick: string;
  real_time_factor: number | null;
  timing: Record<'bullet_s' | 'terrain_s' | 'output_s' | 'wall_s', number | null>;
}

export interface RunHeader {
  block?: number;
  folder: string;
  kind: string;
  title: string;
  terrain: string;
  version: string;
  seed: number;
  scenario: string;
  soil: string;
  status: string;
  ground: string;
  end_state_hash: string;
  total_mass_kg: number | null;
  gravity: number | null;
  bodies: string[];
  wheels: string[];
  assumptions: Assumption[];
  frames: number;
  frame_rate?: number;
  thinned: boolean;
  time: ArrayRef;
  pose_time: ArrayRef;
  channels: Record<string, Channel>;
  statistics: Record<string, Statistics>;
  ground_grid?: { x: ArrayRef; y: ArrayRef; height: ArrayRef };
  meshes: Record<string, { vertices: ArrayRef; triangles: ArrayRef }>;
  /** Grains near the wheels: x, y, z, radius of each set. */
  points?: { time: ArrayRef; frames: ArrayRef[][] };
  /** Squares of the surface of grains that changed up to each time: x, y, rise. */
  surface?: { time: ArrayRef; side: number; frames: ArrayRef[][] };
  spectrum?: { resolution: number; segments: number; density: number[] };
  summary: Summary;
  warnings: string[];
}

export type Cell = number | string | null;
export interface Table {
  columns: string[];
  rows: Cell[][];
  notes: string[];
}

export interface RigHeader {
  block: number;
  folder: string;
  title: string;
  terrain: string;
  soil: string;
  version: string;
  scenario: string;
  ground: string;
  sweep: Table;
  errors: Table | null;
  measured: Table | null;
  cases: RunHeader[];
  assumptions: Assumption[];
  warnings: string[];
}

export interface FigureSeries {
  name: string;
  style: 'line' | 'dashed' | 'points';
  x: (number | null)[];
  y: (number | null)[];
  error: (number | null)[];
  colour: number;
}

export type FigureItem =
  | { kind: 'plot'; title: string; x_label: string; y_label: string; caption: string; log_x: boolean; log_y: boolean; series: FigureSeries[] }
  | { kind: 'table'; title: string; columns: string[]; rows: string[][] }
  | { kind: 'text'; text: string };

/** A page of figures: `grouser plot`, `grouser fit`. */
export interface Figures {
  summary: string;
  items: FigureItem[];
}

export interface Header {
  format: number;
  title: string;
  runs: RunHeader[];
  rigs: RigHeader[];
  figures?: Figures;
}

/** A run with its numbers, decoded when first asked for. */
export class Run {
  readonly time: Float64Array;
  readonly poseTime: Float64Array;
  private readonly cache = new Map<string, Float64Array>();

  constructor(
    readonly header: RunHeader,
    private readonly block: Block,
    readonly label: string,
    readonly colour: string,
  ) {
    this.time = block.read(header.time);
    this.poseTime = block.read(header.pose_time);
  }

  /** Scalar channel on `time`. */
  series(name: string): Float64Array | undefined {
    const ref = this.header.channels[name]?.data;
    return ref && this.decode(name, ref);
  }

  /** Components of a vector channel on `poseTime`. */
  vector(name: string): Float64Array[] | undefined {
    return this.header.channels[name]?.components?.map((ref, k) => this.decode(`${name}[${k}]`, ref));
  }

  read(ref: ArrayRef): Float64Array {
    return this.block.read(ref);
  }

  /** Value of a scalar channel at time t, linear between frames. */
  at(name: string, t: number): number {
    const y = this.series(name);
    return y ? interpolate(this.time, y, t) : NaN;
  }

  private decode(key: string, ref: ArrayRef): Float64Array {
    let values = this.cache.get(key);
    if (!values) this.cache.set(key, (values = this.block.read(ref)));
    return values;
  }
}

/** Last index i with x[i] <= v, at least 0. */
export function indexBefore(x: ArrayLike<number>, v: number): number {
  let lo = 0;
  let hi = x.length - 1;
  while (lo < hi) {
    const mid = (lo + hi + 1) >> 1;
    if (x[mid] <= v) lo = mid;
    else hi = mid - 1;
  }
  return lo;
}

export function interpolate(x: ArrayLike<number>, y: ArrayLike<number>, v: number): number {
  if (x.length === 0) return NaN;
  const i = indexBefore(x, v);
  const j = Math.min(i + 1, x.length - 1);
  const span = x[j] - x[i];
  const w = span > 0 ? Math.min(1, Math.max(0, (v - x[i]) / span)) : 0;
  return y[i] + w * (y[j] - y[i]);
}
