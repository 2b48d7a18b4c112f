// Plots that share the cursor, the zoom and the time of the playback.
import uPlot from 'uplot';
import type { Clock } from './clock';
import { css, el } from './text';

export interface Line {
  label: string;
  x: ArrayLike<number>;
  y: ArrayLike<number>;
  colour: string;
  dash?: number[];
  /** Marks instead of a line. */
  points?: boolean;
  /** Half lengths of error bars. */
  error?: ArrayLike<number>;
  width?: number;
}

export interface ChartOptions {
  title: string;
  unit: string;
  xLabel: string;
  /** 'time': linked cursor and zoom; 'distance': time is shown through `timeToX`. */
  axis: 'time' | 'other';
  timeToX?: (t: number) => number;
  xToTime?: (x: number) => number;
  logarithmic?: boolean;
  logX?: boolean;
  logY?: boolean;
  yLabel?: string;
  /** Draw every line through its own points in their own order (loops, repeats, gaps), with room for all error bars. */
  free?: boolean;
  height?: number;
  note?: string;
  /** Room left and right of the outer points. */
  margin?: boolean;
}

const sync = uPlot.sync('time');

/** A colour, also one that the colour scheme gives: "var(--ink)". */
const paint = (colour: string): string => (colour.startsWith('var(') ? css(colour.slice(4, -1)) : colour);

/** Values for the cursor and the legend of lines that may turn back: sorted by x, the first of equal x. */
function sorted(l: Line): [number[], (number | null)[]] {
  const order = Array.from(l.x, (_, i) => i).filter((i) => Number.isFinite(l.x[i]));
  order.sort((a, b) => l.x[a] - l.x[b] || a - b);
  const kept = order.filter((i, k) => k === 0 || l.x[i] !== l.x[order[k - 1]]);
  return [kept.map((i) => l.x[i]), kept.map((i) => (Number.isFinite(l.y[i]) ? l.y[i] : null))];
}

function aligned(lines: Line[], free: boolean): uPlot.AlignedData {
  if (free)
    return uPlot.join(
      lines.map(sorted),
      lines.map(() => [1, 1]),
    );
  const first = lines[0].x;
  if (lines.every((l) => l.x === first))
    return [Array.from(first), ...lines.map((l) => Array.from(l.y, (v) => (Number.isFinite(v) ? v : null)))];
  return uPlot.join(
    lines.map((l) => [Array.from(l.x), Array.from(l.y, (v) => (Number.isFinite(v) ? v : null))]),
    lines.map(() => [1, 1]),
  );
}

/** Tick text: plain digits with a real minus; powers of ten on a logarithmic axis. */
function tick(v: number | null): string {
  if (v === null) return '';
  const a = Math.abs(v);
  if (a !== 0 && (a < 1e-3 || a >= 1e5)) {
    const [m, e] = v.toExponential(0).split('e');
    return m === '1' ? `1e${Number(e)}` : `${m}e${Number(e)}`;
  }
  return String(Number(v.toPrecision(6))).replace('-', '\u2212');
}

/** Ticks of a logarithmic axis that carry a number: decades, and below two decades also 2 and 5. */
function logTicks(_: uPlot, splits: number[]): (number | null)[] {
  const few = splits.length > 0 && splits[splits.length - 1] / splits[0] < 100;
  return splits.map((v) => {
    const lead = Math.round(v / 10 ** Math.floor(Math.log10(v) + 1e-9));
    return lead === 1 || (few && (lead === 2 || lead === 5)) ? v : null;
  });
}

/** Range of an axis that holds every value (with its error bar) of the lines; a logarithmic one ends ten decades below the greatest. */
function span(lines: Line[], axis: 'x' | 'y', logarithmic: boolean): [number, number] {
  let lo = Infinity;
  let hi = -Infinity;
  for (const l of lines)
    for (let i = 0; i < l.x.length; ++i) {
      if (!Number.isFinite(l.x[i]) || !Number.isFinite(l.y[i])) continue;
      const v = l[axis][i];
      const e = axis === 'y' && l.error && l.error[i] > 0 ? l.error[i] : 0;
      for (const b of [v - e, v + e]) {
        if (logarithmic && !(b > 0)) continue;
        lo = Math.min(lo, b);
        hi = Math.max(hi, b);
      }
    }
  if (!(lo <= hi)) return logarithmic ? [0.1, 10] : [0, 1];
  if (logarithmic) {
    lo = Math.max(lo, 1e-10 * hi, 1e-15);
    const room = Math.max(0.03 * Math.log10(hi / lo), 0.02);
    return [lo / 10 ** room, hi * 10 ** room];
  }
  const room = hi > lo ? 0.04 * (hi - lo) : Math.max(0.1 * Math.abs(hi), 1e-9);
  // A range that begins at zero is not pushed below it.
  return [lo >= 0 && lo < room ? Math.min(lo, 0) : lo - room, hi + room];
}

export class Charts {
  private readonly all: Chart[] = [];

  constructor(readonly clock: Clock | null) {
    clock?.listen(() => this.all.forEach((c) => c.showTime()));
  }

  add(options: ChartOptions, lines: Line[]): HTMLElement {
    const chart = new Chart(this, options, lines);
    this.all.push(chart);
    return chart.root;
  }

  /** Draw those that are not yet drawn; sizes are known only when the page holds them. */
  mount(): void {
    this.all.forEach((c) => c.mount());
  }

  /** Take every chart out of `host`. */
  remove(host: HTMLElement): void {
    for (const c of this.all.filter((k) => host.contains(k.root))) {
      c.plot?.destroy();
      c.root.remove();
      this.all.splice(this.all.indexOf(c), 1);
    }
  }

  restyle(): void {
    this.all.forEach((c) => c.plot?.redraw(false, true));
  }

  zoomed(from: Chart, min: number, max: number): void {
    for (const c of this.all) if (c !== from && c.options.axis === 'time') c.zoom(min, max);
  }
}

export class Chart {
  readonly root: HTMLElement;
  plot?: uPlot;
  private readonly host: HTMLElement;
  private readonly marker = el('div', { class: 'marker', hidden: '' });
  private zooming = false;

  constructor(
    private readonly charts: Charts,
    readonly options: ChartOptions,
    private readonly lines: Line[],
  ) {
    this.host = el('div', { class: 'plot' });
    const unit = options.unit ? el('span', { class: 'unit' }, `[${options.unit}]`) : null;
    this.root = el('figure', {}, el('figcaption', {}, options.title, ' ', unit), this.host);
    if (options.note) this.root.append(el('p', { class: 'note' }, options.note));
  }

  mount(): void {
    if (this.plot || !this.host.isConnected || this.lines.length === 0) return;
    this.plot = this.create();
    new ResizeObserver(() => {
      const width = this.host.clientWidth;
      if (this.plot && width > 0 && width !== this.plot.width) this.plot.setSize({ width, height: this.plot.height });
      this.showTime();
    }).observe(this.host);
    this.showTime();
  }

  zoom(min: number, max: number): void {
    if (!this.plot) return;
    this.zooming = true;
    this.plot.setScale('x', { min, max });
    this.zooming = false;
  }

  showTime(): void {
    const clock = this.charts.clock;
    if (!clock || !this.plot) return;
    const x = this.options.axis === 'time' ? clock.t : this.options.timeToX?.(clock.t);
    if (x === undefined) return;
    this.marker.hidden = false;
    const left = this.plot.valToPos(x, 'x');
    const inside = left >= 0 && left <= this.plot.over.clientWidth;
    this.marker.style.display = inside ? '' : 'none';
    this.marker.style.transform = `translateX(${left}px)`;
  }

  private create(): uPlot {
    const o = this.options;
    const ink = () => css('--ink-soft');
    const grid = { stroke: () => css('--grid'), width: 1 };
    const font = '12px system-ui, sans-serif';
    const values = (_: uPlot, splits: (number | null)[]) => splits.map(tick);
    const shown = (_: uPlot, v: number | null) => (v === null || v === undefined ? '' : tick(Number(v.toPrecision(4))));
    const logX = o.logarithmic || o.logX;
    const logY = o.logarithmic || o.logY;
    const log = { distr: 3 as const };
    const [xSpan, ySpan] = [span(this.lines, 'x', !!logX), span(this.lines, 'y', !!logY)];
    let whole = true;
    // The whole x range at first, then what the user dragged; y holds everything.
    const xRange = (_: uPlot, lo: number, hi: number): [number, number] => {
      const asked: [number, number] = whole || lo === null || hi === null ? xSpan : [lo, hi];
      whole = false;
      return asked;
    };
    const rangeX = o.free ? { range: xRange } : o.margin ? { range: (_: uPlot, lo: number, hi: number): [number, number] => [lo - 0.04 * (hi - lo), hi + 0.04 * (hi - lo)] } : {};
    // Nearly equal values get a span that the labels of the axis can tell apart.
    const bars = this.lines.flatMap((l) => (l.error ? Array.from(l.y, (v, i) => [v - l.error![i], v + l.error![i]]).flat() : [])).filter(Number.isFinite);
    const yRange = (_: uPlot, lo: number | null, hi: number | null): uPlot.Range.MinMax => {
      if (lo === null || hi === null) return [null, null];
      lo = Math.min(lo, ...bars);
      hi = Math.max(hi, ...bars);
      const least = 1e-4 * Math.max(Math.abs(lo), Math.abs(hi));
      return hi - lo < least ? [lo - 5 * least, hi + 5 * least] : uPlot.rangeNum(lo, hi, 0.1, true);
    };
    const plot: uPlot = new uPlot(
      {
        width: Math.max(200, this.host.clientWidth),
        height: o.height ?? 230,
        padding: [8, 14, 0, 0],
        cursor: {
          drag: { x: true, y: false },
          focus: { prox: 24 },
          ...(o.axis === 'time' ? { sync: { key: sync.key, scales: ['x', null] } } : {}),
        },
        focus: { alpha: 0.35 },
        scales: {
          x: { time: false, ...(logX ? log : {}), ...rangeX },
          y: { ...(logY ? log : {}), ...(o.free ? { range: () => ySpan } : logY ? {} : { range: yRange }) },
        },
        axes: [
          { stroke: ink, grid, ticks: grid, font, label: o.xLabel, labelFont: font, labelSize: 20, size: 34, values, ...(o.free && logX ? { filter: logTicks } : {}) },
          { stroke: ink, grid, ticks: grid, font, ...(o.yLabel ? { label: o.yLabel, labelFont: font, labelSize: 20 } : {}), ...(o.free && logY ? { filter: logTicks } : {}), values, size: (_, v) => 18 + 7.5 * Math.max(2, ...(v ?? []).map((s) => (s ?? '').length)) },
        ],
        series: [
          { label: o.xLabel, value: shown },
          ...this.lines.map(
            (l): uPlot.Series => ({
              label: l.label,
              stroke: () => paint(l.colour),
              width: l.width ?? 1.25,
              dash: l.dash,
              spanGaps: true,
              value: shown,
              ...(o.free
                ? { paths: (u: uPlot) => this.freePath(u, l), points: { show: false } }
                : l.points
                ? { paths: () => null, points: { show: true, size: 8, fill: () => paint(l.colour) } }
                : { points: { show: l.x.length <= 40, size: 6, fill: () => paint(l.colour) } }),
            }),
          ),
        ],
        hooks: {
          draw: [(u) => this.drawErrors(u), ...(o.free ? [(u: uPlot) => this.drawMarks(u)] : [])],
          setScale: [
            (u, key) => {
              if (key !== 'x') return;
              this.showTime();
              const { min, max } = u.scales.x;
              if (!this.zooming && o.axis === 'time' && min != null && max != null) this.charts.zoomed(this, min, max);
            },
          ],
        },
      },
      aligned(this.lines, !!o.free),
      this.host,
    );
    plot.over.append(this.marker);
    if (o.axis === 'time' || o.xToTime) {
      let down = 0;
      plot.over.addEventListener('mousedown', (e) => (down = e.clientX));
      plot.over.addEventListener('click', (e) => {
        // A drag zooms; only a click moves the time.
        if (Math.abs(e.clientX - down) > 3) return;
        const x = plot.posToVal(e.clientX - plot.over.getBoundingClientRect().left, 'x');
        this.charts.clock?.seek(o.xToTime ? o.xToTime(x) : x);
      });
    }
    return plot;
  }

  /** Through the line's own points; a value that is missing is a gap. */
  private freePath(u: uPlot, l: Line): uPlot.Series.Paths | null {
    if (l.points) return null;
    const path = new Path2D();
    let pen = false;
    for (let i = 0; i < l.x.length; ++i) {
      if (!this.drawable(l, i)) {
        pen = false;
        continue;
      }
      const x = u.valToPos(l.x[i], 'x', true);
      const y = u.valToPos(l.y[i], 'y', true);
      if (pen) path.lineTo(x, y);
      else path.moveTo(x, y);
      pen = true;
    }
    return { stroke: path, fill: null, flags: 1 } as unknown as uPlot.Series.Paths;
  }

  private drawable(l: Line, i: number): boolean {
    const o = this.options;
    return Number.isFinite(l.x[i]) && Number.isFinite(l.y[i]) && (!o.logX || l.x[i] > 0) && (!o.logY || l.y[i] > 0);
  }

  /** Points of marked lines, and of short ones so that one sees where the values are. */
  private drawMarks(u: uPlot): void {
    const c = u.ctx;
    c.save();
    c.beginPath();
    c.rect(u.bbox.left - 6, u.bbox.top - 6, u.bbox.width + 12, u.bbox.height + 12);
    c.clip();
    for (const [k, l] of this.lines.entries()) {
      if (u.series[k + 1].show === false || !(l.points || l.x.length <= 20)) continue;
      c.fillStyle = paint(l.colour);
      const r = (l.points ? 3.6 : 2.4) * devicePixelRatio;
      for (let i = 0; i < l.x.length; ++i) {
        if (!this.drawable(l, i)) continue;
        c.beginPath();
        c.arc(u.valToPos(l.x[i], 'x', true), u.valToPos(l.y[i], 'y', true), r, 0, 2 * Math.PI);
        c.fill();
      }
    }
    c.restore();
  }

  private drawErrors(u: uPlot): void {
    const c = u.ctx;
    c.save();
    for (const [k, l] of this.lines.entries()) {
      if (!l.error || u.series[k + 1].show === false) continue;
      c.strokeStyle = paint(l.colour);
      c.lineWidth = 1.2 * devicePixelRatio;
      const half = 3.5 * devicePixelRatio;
      c.beginPath();
      for (let i = 0; i < l.x.length; ++i) {
        const e = l.error[i];
        if (!(e > 0) || !Number.isFinite(l.y[i])) continue;
        const x = u.valToPos(l.x[i], 'x', true);
        const foot = this.options.logY && l.y[i] - e <= 0 ? l.y[i] : l.y[i] - e;
        const lower = u.valToPos(foot, 'y', true);
        const upper = u.valToPos(l.y[i] + e, 'y', true);
        c.moveTo(x, lower);
        c.lineTo(x, upper);
        for (const y of [lower, upper]) {
          c.moveTo(x - half, y);
          c.lineTo(x + half, y);
        }
      }
      c.stroke();
    }
    c.restore();
  }
}
